// Stone under water: little of it is bare, most is a crust of what grows on it.
#include "optics.glsl"
#include "bites.glsl"
#include "relief.glsl"
#define BRIGHTEST 16.0
#include "show.glsl"
#ifdef FADING
#include "fades.glsl"
#endif

in vec3 v_world;
in vec3 v_normal;
centroid in vec3 v_light;
centroid in vec3 v_cover;
centroid in vec3 v_clear;
centroid in vec3 v_veil;

const vec3 DARK = vec3(0.23, 0.17, 0.13);
const vec3 OCHRE = vec3(0.56, 0.40, 0.22);
const vec3 CREAM = vec3(0.70, 0.60, 0.45);
const vec3 TURF = vec3(0.20, 0.21, 0.05);
const vec3 CORALLINE = vec3(0.70, 0.30, 0.40);
const vec3 VIOLET = vec3(0.42, 0.24, 0.44);
const vec3 SPONGE = vec3(0.86, 0.33, 0.06);
const vec3 LEMON = vec3(0.78, 0.62, 0.12);

void main() {
#ifdef FADING
    if (faded(u_fade)) discard;
#endif
    vec3 normal = normalize(v_normal);
    vec3 share = normal * normal;
    share *= share;
    share /= share.x + share.y + share.z;
    vec3 p = v_world / RELIEF_CM;
#ifdef CLOSE_UP
    vec3 slope;
    vec2 shape = relief_at(p, share, slope);
    float height = shape.x, polyps = shape.y;
    // At arm's length a finer relief, turned so that the two never coincide.
    float near = 1.0 - smoothstep(80.0, 260.0, distance(v_world, u_eye));
    if (near > 0.0) {
        vec3 finer;
        vec2 fine = relief_at(4.3 * p.yzx + 0.37, share.yzx, finer);
        height += 0.4 * near * fine.x;
        slope += 0.55 * near * finer.zxy;
        polyps = mix(polyps, fine.y, 0.35 * near);
    }
#else
    // The relief is seen from above, and from that side which a wall faces more; where it turns
    // from one side to the other it is flat.
    bool side = share.x > share.y;
    vec4 wall = RELIEF_SPAN * texture(u_relief, side ? p.yz : p.xz) - 0.5 * RELIEF_SPAN;
    vec4 level = RELIEF_SPAN * texture(u_relief, p.xy) - 0.5 * RELIEF_SPAN;
    float sides = share.x + share.y;
    wall *= min(3.0 * abs(share.x - share.y), sides);
    level *= share.z;
    vec4 relief = wall + level;
    vec3 slope = vec3(level.y, level.z, wall.z);
    slope.xy += side ? vec2(0.0, wall.y) : vec2(wall.y, 0.0);
    float height = relief.x, polyps = relief.w;
#endif
    float up = normal.z;
    float hollow = v_light.z, turf = v_cover.x, algae = v_cover.y, sponge = v_cover.z;
    normal = normalize(normal - slope + normal * dot(slope, normal));

    vec3 stone = mix(DARK, mix(OCHRE, CREAM, clamp(0.5 + 1.2 * algae, 0.0, 1.0)),
                     clamp(0.62 + 0.5 * height - 0.35 * hollow, 0.0, 1.0));
    // Pink crusts where light is weak, violet ones deeper in; turf where it is strong.
    float pink = smoothstep(-0.02, 0.25, algae + 0.25 * height - 0.15 * up + 0.04);
    vec3 crust = mix(CORALLINE, VIOLET, smoothstep(-0.1, 0.5, turf + 0.4 * hollow - 0.3 * up));
    stone = mix(stone, crust * (0.8 + 0.5 * height), 0.8 * pink);
    float green = smoothstep(0.0, 0.32, 0.75 * turf + 0.55 * up + 0.2 * height - 0.34);
    stone = mix(stone, TURF * (1.0 + 0.6 * height), 0.8 * green);
    float orange = smoothstep(0.40, 0.50, sponge + 0.30 * polyps + 0.1 * height - 0.12 * up);
    vec3 living = mix(SPONGE, LEMON, smoothstep(-0.1, 0.1, turf));
    stone = mix(stone, living * (0.55 + 0.8 * polyps), orange);
    stone = mix(stone, CREAM * (1.1 + 0.5 * height), 0.75 * bitten(v_world));  // scraped bare

    stone *= clamp(0.85 + 0.5 * height, 0.3, 1.2);
    vec3 light = SUNLIGHT * (max(dot(normal, SUN) + 0.25, 0.0) * v_light.y / 1.25 * sunny(v_world + 6.0 * normalize(v_normal)));
    light += mix(SANDLIGHT, SKYLIGHT, 0.5 + 0.5 * normal.z) * v_light.x;
#ifdef LIT
    light += lamplight_on(v_world, normal, 0.1) / daylight(v_world.z);  // as that is in `v_clear`
#endif
    show(stone * light * v_clear, v_veil, v_clear / (EXPOSURE * daylight(v_world.z)), 1.0);
}
