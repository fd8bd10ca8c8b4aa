in vec4 v_colour;
flat in vec2 v_streak;
flat in float v_radius;

out vec4 f_colour;

// A soft speck, drawn out along its way.
void main() {
    vec2 place = gl_PointCoord * 2.0 - 1.0;
    float along = clamp(dot(place, v_streak) / max(dot(v_streak, v_streak), 1e-6), -1.0, 1.0);
    vec2 off = (place - along * v_streak) / v_radius;
    float soft = max(1.0 - dot(off, off), 0.0);
    f_colour = vec4(v_colour.rgb, v_colour.a * soft * soft);
}
