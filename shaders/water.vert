uniform mat4 u_inverse;  // of projection and view
uniform vec3 u_eye;

out vec3 v_ray;

// One triangle over the whole viewport, at the far plane.
void main() {
    vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2.0 - 1.0;
    vec4 far = u_inverse * vec4(corner, 1.0, 1.0);
    v_ray = far.xyz / far.w - u_eye;
    gl_Position = vec4(corner, 1.0, 1.0);
}
