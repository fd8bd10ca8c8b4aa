in vec3 a_position;
in vec2 a_slope;

uniform mat4 u_view_projection;

out vec3 v_world;
out vec2 v_slope;

void main() {
    v_world = a_position;
    v_slope = a_slope;
    gl_Position = u_view_projection * vec4(a_position, 1.0);
}
