// A leaf of seaweed lets light through, so both its sides are bright.
#include "optics.glsl"
#define BRIGHTEST 16.0
#include "show.glsl"

in vec3 v_world;
in vec3 v_normal;
in vec4 v_place;
flat in vec3 v_colour;
flat in float v_rib;
centroid in vec3 v_sun;
centroid in vec3 v_clear;
centroid in vec3 v_veil;

void main() {
    vec3 view = normalize(u_eye - v_world);
    vec3 normal = normalize(v_normal);
    if (dot(normal, view) < 0.0) normal = -normal;
    float t = v_place.x, u = abs(v_place.y);
    vec2 spot = vec2(v_place.y * 0.11 + v_place.z, t * 0.9);
    float speck = texture(u_noise, spot).r;
    // Paler toward the tip, darker at the root and between the ribs; the midrib shows light.
    vec3 leaf = v_colour * mix(vec3(0.75, 0.8, 0.8), vec3(1.35, 1.15, 1.0), t) * (1.0 + 0.16 * speck);
    float grain = fwidth(u);
    float rib = v_rib * (1.0 - smoothstep(0.07, 0.13 + grain, u)) * (1.0 - smoothstep(0.3, 0.9, grain));
    // Veins run from the midrib outward and up.
    float vein = 38.0 * t - 7.0 * u + 3.0 * v_place.z;
    float seen = 1.0 - smoothstep(0.25, 0.6, fwidth(vein) / 6.2832);
    leaf *= 1.0 + 0.45 * rib * (1.0 - t) - 0.16 * smoothstep(0.55, 1.0, u) + 0.1 * seen * sin(vein);
    leaf = mix(leaf, vec3(0.24, 0.20, 0.13), 0.5 * smoothstep(1.3, 2.0, speck));
    float dense = 0.0, gloss = 0.0;
#ifdef CLOSE_UP
    // Puckered between the veins, with dark spots and a crust of what settles on old leaves.
    vec2 fine = vec2(v_place.y * 0.9 + 3.0 * v_place.z, t * 7.0);
    float near = 1.0 - smoothstep(0.2, 0.7, 18.0 * max(fwidth(fine.x), fwidth(fine.y)));
    float here = texture(u_noise, fine * vec2(0.3, 0.12)).r;
    float pucker = near * (here + 0.8 * cos(vein) * seen);
    vec3 rises = vec3(dFdx(pucker), dFdy(pucker), 0.0);
    vec3 dx = dFdx(v_world), dy = dFdy(v_world);
    float area = dot(cross(dx, dy), normal);
    vec3 lean = (rises.x * cross(dy, normal) + rises.y * cross(normal, dx)) / (abs(area) < 1e-8 ? 1e-8 : area);
    normal = normalize(normal - clamp(0.35 * lean, -0.45, 0.45));
    dense = 0.3 * near * clamp(0.6 * here, -0.6, 1.0);
    leaf *= 1.0 - 0.45 * dense;
    float crust = smoothstep(1.3, 2.2, speck + 0.6 * here * near + 0.4 * (1.0 - t));
    leaf = mix(leaf, vec3(0.17, 0.145, 0.10), 0.5 * crust);
    dense += 0.6 * crust + 0.3 * seen * (0.5 + 0.5 * sin(vein));
    gloss = 1.0 - 0.8 * crust;
#endif

    vec3 light = light_from(v_sun, v_world, normal, 0.3);
    // What comes through from the other side is yellower.
    vec3 through = vec3(1.15, 1.0, 0.32) * (1.0 - 0.6 * rib) * (1.0 - dense);
    float glow = max(dot(-view, SUN), 0.0);
    glow *= glow;
    float behind = max(dot(-normal, SUN), 0.0) + 0.2 + 0.7 * glow * glow;
    light += 0.75 * through * behind * v_sun;
    light *= mix(0.35, 1.0, smoothstep(0.0, 0.35, v_place.w));  // shaded by its cluster at the foot
    vec3 lit = leaf * light;
#ifdef CLOSE_UP
    float mirror = max(dot(normal, normalize(SUN + view)), 0.0);
    mirror *= mirror; mirror *= mirror; mirror *= mirror;
    lit += 0.035 * gloss * mirror * mirror * v_sun;
#endif
    show(EXPOSURE * lit * v_clear, v_veil, v_clear, 1.0);
}
