// Shafts of light in every direction from the eye: a map about the sun, turn by cosine, so that
// they fan out from it as they do in perspective. SAMPLES is how many places along a ray count.
#include "optics.glsl"

in vec2 v_place;
out float f_light;

const float NEAREST = 70.0;  // cm
const float TILE = 620.0;    // cm, of the light that waves gather
const float TEXEL = TILE / 256.0;

void main() {
    float turn = 6.2831853 * v_place.x, toward = 1.0 - 2.0 * v_place.y;
    float aside = sqrt(max(1.0 - toward * toward, 0.0));
    vec3 direction = SUN * toward + aside * (ACROSS * cos(turn) + ASIDE * sin(turn));
    float ratio = pow(2.2 / (u_extinction * NEAREST), 1.0 / float(SAMPLES));
    float light = 0.0, total = 0.0, distance = NEAREST;
    for (int k = 0; k < SAMPLES; ++k) {
        vec3 at = u_eye + direction * distance;
        // Along the sun's rays the light stays as it is below the surface, and slowly spreads.
        vec2 entry = (at.xy - SUN.xy / SUN.z * at.z) / TILE;
        float blur = log2(max(0.03 * distance, TEXEL) / TEXEL);
        float a = textureLod(u_caustics, entry + u_time * vec2(0.011, 0.006), blur).g;
        float b = textureLod(u_caustics, 0.71 * entry.yx - u_time * vec2(0.007, 0.012), blur).g;
        float weight = distance * exp(-u_extinction * distance) * step(at.z, 0.0);
        light += weight * (a * b - 1.0);
        total += weight;
        distance *= ratio;
    }
    light /= max(total, 1e-6);
    // Seen plainly toward the sun, faintly aside and hardly from above; the deeper the fainter.
    float seen = 0.10 + 0.55 * max(toward, 0.0);
    seen *= smoothstep(-0.75, 0.25, direction.z) * exp(u_eye.z / 1600.0);
    f_light = seen * light;
}
