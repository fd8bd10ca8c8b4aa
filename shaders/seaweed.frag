// A leaf of seaweed lets light through, so both its sides are bright.
#include "optics.glsl"
#include "show.glsl"

in vec3 v_world;
in vec3 v_normal;
in vec4 v_place;
flat in vec3 v_colour;
flat in float v_rib;
in vec3 v_sun;
in vec3 v_clear;
in vec3 v_veil;

void main() {
    vec3 view = normalize(u_eye - v_world);
    vec3 normal = normalize(v_normal);
    if (dot(normal, view) < 0.0) normal = -normal;
    float t = v_place.x, u = abs(v_place.y);
    float speck = texture(u_noise, vec2(v_place.y * 0.11 + v_place.z, t * 0.9)).r;
    // Paler toward the tip, darker at the root and between the ribs; the midrib shows light.
    vec3 leaf = v_colour * mix(vec3(0.75, 0.8, 0.8), vec3(1.45, 1.2, 1.0), t) * (1.0 + 0.16 * speck);
    float grain = fwidth(u);
    float rib = v_rib * (1.0 - smoothstep(0.07, 0.13 + grain, u)) * (1.0 - smoothstep(0.3, 0.9, grain));
    // Veins run from the midrib outward and up.
    float vein = 38.0 * t - 7.0 * u + 3.0 * v_place.z;
    float seen = 1.0 - smoothstep(0.25, 0.6, fwidth(vein) / 6.2832);
    leaf *= 1.0 + 0.45 * rib * (1.0 - t) - 0.16 * smoothstep(0.55, 1.0, u) + 0.1 * seen * sin(vein);
    leaf = mix(leaf, vec3(0.24, 0.20, 0.13), 0.5 * smoothstep(1.3, 2.0, speck));

    vec3 light = light_from(v_sun, v_world, normal, 0.3);
    // What comes through from the other side is yellower.
    vec3 through = vec3(1.25, 1.1, 0.35) * (1.0 - 0.6 * rib);
    float glow = max(dot(-view, SUN), 0.0);
    glow *= glow;
    float behind = max(dot(-normal, SUN), 0.0) + 0.25 + 0.6 * glow * glow;
    light += 0.75 * through * behind * v_sun;
    light *= mix(0.35, 1.0, smoothstep(0.0, 0.35, v_place.w));  // shaded by its cluster at the foot
    show(vec4(EXPOSURE * leaf * light * v_clear + v_veil, 1.0));
}
