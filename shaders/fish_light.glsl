// A colour as an individual wears it: `tone` is a tint and how saturated it is.
vec3 toned(vec3 colour, vec4 tone) {
    float grey = dot(colour, vec3(0.2126, 0.7152, 0.0722));
    return max(mix(vec3(grey), colour, tone.w), 0.0) * tone.rgb;
}

// Silver in the skin lies in upright platelets, whatever the curve of the flank (Denton 1970): it
// mirrors the water beside a fish, not that above. A surface's normal, as platelets are turned.
const float UPRIGHT = 0.3;

vec3 platelets(vec3 normal, float silver) {
    return normalize(vec3(normal.xy, normal.z * mix(1.0, UPRIGHT, silver)));
}

// What is bright and without colour is silver, as far as the fish is `silvery`.
float silver_of(vec3 skin, float silvery) {
    return silvery * smoothstep(0.05, 0.5, min(skin.r, min(skin.g, skin.b)));
}

// The colours of platelets turn with the angle from which they are seen.
vec3 sheen_of(float facing, float relief) {
    return 0.75 + 0.5 * abs(2.0 * fract(1.4 * facing + 0.5 * relief + vec3(0.0, 0.3, 0.6)) - 1.0);
}

// The share of the light around that silver mirrors.
vec3 mirroring(vec3 skin, float silver, vec3 sheen) {
    return silver * sheen * (0.5 + 0.4 * skin);
}

const float DARK = 0.8;  // share of the diffuse light that silver does not scatter
