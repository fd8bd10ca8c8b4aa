// A finished picture, stretched over a window.
uniform sampler2D u_picture;

in vec2 v_place;
out vec4 f_colour;

void main() {
    f_colour = vec4(texture(u_picture, v_place).rgb, 1.0);
}
