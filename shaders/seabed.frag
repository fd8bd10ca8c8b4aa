#include "optics.glsl"

in vec3 v_world;
in vec2 v_slope;
in vec3 v_clear;
in vec3 v_veil;
out vec4 f_colour;

const vec3 PALE = vec3(0.72, 0.58, 0.38);
const vec3 DARK = vec3(0.44, 0.34, 0.22);
const float RIPPLE_CM = 13.0;

void main() {
    vec2 p = v_world.xy;
    float broad = texture(u_noise, p / 610.0).r;
    float middle = texture(u_noise, p.yx / 173.0).r;
    float fine = texture(u_noise, p / 37.0).r;
    // Ripples lie across the current and wander; they fade before they alias.
    vec2 across = vec2(0.93, 0.37);
    float phase = 6.2832 / RIPPLE_CM * dot(p, across) + 2.4 * broad + 1.1 * middle;
    float resolved = 1.0 - smoothstep(0.6, 2.4, fwidth(phase));
    float height = 0.55 + 0.45 * clamp(0.8 + 0.5 * middle, 0.0, 1.0);
    float ripple = sin(phase) + 0.28 * sin(2.0 * phase + 1.0);
    vec2 slope = v_slope + across * (0.24 * height * resolved * (cos(phase) + 0.5 * cos(2.0 * phase + 1.0)));
    slope += 0.05 * vec2(fine, middle);
    vec3 normal = normalize(vec3(-slope, 1.0));
    vec3 sand = mix(DARK, PALE, clamp(0.62 + 0.14 * broad + 0.10 * middle + 0.07 * fine, 0.0, 1.0));
    sand *= 1.0 + 0.10 * resolved * ripple;
    vec3 light = light_on(v_world, normal, 0.0);
    f_colour = vec4(EXPOSURE * sand * light * v_clear + v_veil, 1.0);
}
