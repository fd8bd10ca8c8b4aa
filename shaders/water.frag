in vec3 v_open;
out vec4 f_colour;

void main() {
    f_colour = vec4(v_open, 1.0);
}
