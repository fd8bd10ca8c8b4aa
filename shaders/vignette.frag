// A darker rim around straight ahead of an eye.
uniform vec3 u_rim;  // angles, rad, where it begins and where it is darkest; opacity there

in vec2 v_tangent;
out vec4 f_colour;

void main() {
    float aside = atan(length(v_tangent));
    f_colour = vec4(0.0, 0.012, 0.02, u_rim.z * smoothstep(u_rim.x, u_rim.y, aside));
}
