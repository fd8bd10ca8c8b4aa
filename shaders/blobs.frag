// Darkens the sand beneath but not the haze before it: blended, that is what remains.
in vec3 v_veil;
in vec2 v_at;
in float v_dark;
out vec4 f_colour;

void main() {
    float inside = max(1.0 - dot(v_at, v_at), 0.0);
    f_colour = vec4(v_veil, v_dark * inside * inside);
}
