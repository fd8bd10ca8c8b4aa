in vec4 v_colour;

out vec4 f_colour;

// A soft round speck.
void main() {
    vec2 from_centre = gl_PointCoord * 2.0 - 1.0;
    float soft = max(1.0 - dot(from_centre, from_centre), 0.0);
    f_colour = vec4(v_colour.rgb, v_colour.a * soft * soft);
}
