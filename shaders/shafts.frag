// Shafts of light in every direction from the eye: a map about the sun, turn by cosine. What enters
// the water at one place goes on along the sun's rays, and is seen at one turn: so the map's
// columns are shafts, and fan out from the sun in perspective. u_samples places of entry count.
#include "optics.glsl"

uniform int u_samples;
uniform float u_shafting;  // their strength: 1 by day

in vec2 v_place;
out float f_light;

const float NEAREST = 25.0;  // cm, of the places of entry from that of the eye
const float TILE = 800.0;    // cm, of the light that waves gather
const float TEXEL = TILE / 256.0;

void main() {
    float turn = 6.2831853 * v_place.x, toward = 1.0 - 2.0 * v_place.y;
    float aside = sqrt(max(1.0 - toward * toward, 1e-4));
    vec3 across = u_across * cos(turn) + u_aside * sin(turn);
    vec3 direction = SUN * toward + aside * across;
    vec2 way = across.xy - SUN.xy / SUN.z * across.z;  // of the place of entry, as one looks aside
    float ratio = pow(3.0 / (u_extinction * NEAREST), 1.0 / float(u_samples));
    float light = 0.0, total = 1e-6, distance = NEAREST / aside;
    for (int k = 0; k < u_samples; ++k) {
        vec2 entry = (u_eye.xy - SUN.xy / SUN.z * u_eye.z + distance * aside * way) / TILE;
        float blur = max(log2(0.035 * distance * aside / TEXEL), 0.0);
        float a = textureLod(u_caustics, entry + u_time * vec2(0.011, 0.006), blur).r;
        float b = textureLod(u_caustics, 0.71 * entry.yx - u_time * vec2(0.007, 0.012), blur).r;
        float below = clamp(-(u_eye.z + direction.z * distance) / 80.0, 0.0, 1.0);
        float weight = distance * exp(-u_extinction * distance) * below;
        light += weight * (a * b - 1.0);
        total += weight;
        distance *= ratio;
    }
    // Seen plainly toward the sun, faintly aside and hardly from above; the deeper the fainter.
    float seen = 0.10 + 0.50 * max(toward, 0.0);
    seen *= smoothstep(0.0, 0.35, aside) * smoothstep(-0.75, 0.25, direction.z) * exp(u_eye.z / 1600.0);
    f_light = u_shafting * seen * light / total;
}
