// One triangle that covers a picture.
uniform vec4 u_tangents;  // left, right, bottom and top of the picture, at distance 1

out vec2 v_tangent;

void main() {
    vec2 share = vec2(gl_VertexID == 1 ? 2.0 : 0.0, gl_VertexID == 2 ? 2.0 : 0.0);
    v_tangent = mix(u_tangents.xz, u_tangents.yw, share);
    gl_Position = vec4(2.0 * share - 1.0, 0.0, 1.0);
}
