#ifdef PASSES
#include "show.glsl"

flat in vec3 v_veil;
flat in vec3 v_clear;
#else
out vec4 f_colour;
#endif

in vec4 v_colour;
flat in vec2 v_streak;
flat in float v_radius;
#ifdef CLOSE_UP
flat in vec4 v_form;
#endif

#ifdef CLOSE_UP
const float FLAKE = 2.5, THREAD = 3.5, COPEPOD = 6.5;  // numbers below which a shape is that

float soft(vec2 off) {
    float inside = max(1.0 - dot(off, off), 0.0);
    return inside * inside;
}

float line(float off, float wide) {
    off /= wide;
    return 1.0 / (1.0 + off * off * off * off);
}

// Density of a shape at a place in shares of its radius, along and across its axis.
float shape(vec2 p, float form) {
    float whole = soft(0.98 * p);
    float bend = p.y - 0.22 * sin(2.7 * p.x + 1.7 * form);
    if (form < FLAKE) {
        // Flakes of snow: lobes that cling together, and a fibre.
        vec2 way = vec2(cos(2.1 * form), sin(2.1 * form));
        float lobes = soft(2.3 * (p - 0.30 * way)) + 0.8 * soft(2.9 * (p + 0.42 * way.yx))
            + 0.7 * soft(3.3 * (p - 0.5 * vec2(-way.y, way.x))) + 0.35 * soft(1.5 * p);
        return min(lobes, 1.0) + 0.45 * line(bend, 0.07) * whole;
    }
    if (form < THREAD) return line(bend, 0.08) * whole;
    if (form < COPEPOD) {
        // A drop with a tail, and two long feelers that sweep back.
        float body = soft(vec2(1.9 * (p.x - 0.1), (3.6 - 1.3 * p.x) * p.y));
        float tail = line(p.y, 0.06) * smoothstep(-0.95, -0.7, p.x) * step(p.x, 0.0);
        float feeler = line(abs(p.y) - 0.75 * sqrt(max(0.52 - p.x, 0.0)), 0.06) * step(-0.25, p.x);
        return min(1.5 * body + 0.5 * (tail + feeler) * smoothstep(0.0, 0.25, 1.0 - dot(p, p)), 1.0);
    }
    // A jelly: a clear disc with a bright rim.
    float far = length(vec2(p.x, 1.25 * p.y));
    return line(far - 0.72, 0.13) * 0.8 + 0.25 * soft(1.3 * p);
}
#endif

// A soft speck, drawn out along its way.
void main() {
    vec2 place = gl_PointCoord * 2.0 - 1.0;
    float along = clamp(dot(place, v_streak) / max(dot(v_streak, v_streak), 1e-6), -1.0, 1.0);
    vec2 off = (place - along * v_streak) / v_radius;
    float inside = max(1.0 - dot(off, off), 0.0);
    float dense = inside * inside;
#ifdef CLOSE_UP
    if (v_form.w > 0.0) {
        vec2 p = vec2(dot(off, v_form.xy), dot(off, vec2(-v_form.y, v_form.x)));
        dense = mix(dense, step(dot(p, p), 1.0) * shape(p, v_form.z), v_form.w);
    }
#endif
#ifdef PASSES
    show(v_colour.rgb, v_veil, v_clear, v_colour.a * dense);
#else
    f_colour = vec4(v_colour.rgb, v_colour.a * dense);
#endif
}
