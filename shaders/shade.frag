// One colour over a window, blended.
uniform vec4 u_shade;

out vec4 f_colour;

void main() {
    f_colour = u_shade;
}
