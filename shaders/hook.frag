// A steel hook, a worm and a nylon line.
#include "optics.glsl"
#define BRIGHTEST 32.0
#include "show.glsl"

in vec3 v_world;
in vec3 v_normal;
flat in float v_kind;
centroid in float v_strength;

const vec3 STEEL = vec3(0.46, 0.47, 0.48);
const vec3 WORM = vec3(0.78, 0.27, 0.22);
const vec3 NYLON = vec3(0.72, 0.80, 0.80);

void main() {
    vec3 normal = normalize(v_normal);
    vec3 ray = v_world - u_eye;
    float distance = length(ray);
    vec3 look = ray / distance;
    vec3 albedo = v_kind < 0.5 ? STEEL : v_kind < 1.5 ? WORM : NYLON;
    vec3 colour = albedo * light_on(v_world, normal, 0.3);
    if (v_kind < 0.5) {
        // Polished: the sun's streak along the wire, and the water mirrored.
        float glint = pow(max(dot(reflect(look, normal), SUN), 0.0), 24.0);
        colour = 0.5 * colour + 0.9 * water_radiance(reflect(look, normal))
            + 1.6 * glint * sunlight_at(v_world.z);
    }
    vec3 clear = clearness(distance);
    vec3 veil = open_water(look) * (1.0 - clear) + glow(look, distance);
    show(EXPOSURE * colour * clear, veil, clear, v_strength * step(v_world.z, 0.0));
}
