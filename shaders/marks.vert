// Marks of line-up over a finished picture: triangles in shares of a patch's rectangle.
in vec2 in_at;
in vec3 in_colour;
out vec3 v_colour;

void main() {
    v_colour = in_colour;
    gl_Position = vec4(2.0 * in_at - 1.0, 0.0, 1.0);
}
