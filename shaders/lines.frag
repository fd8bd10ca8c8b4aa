uniform float u_width;  // pixels

flat in vec4 v_colour;
in float v_across;

out vec4 f_colour;

// Its edges are soft by a pixel.
void main() {
    float covered = clamp(0.5 * u_width + 0.5 - abs(v_across), 0.0, 1.0);
    f_colour = vec4(v_colour.rgb, v_colour.a * covered);
}
