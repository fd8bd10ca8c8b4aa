// Stone under water: little of it is bare, most is a crust of what grows on it.
#include "optics.glsl"

uniform sampler2D u_relief;  // height, its slopes, polyps

in vec3 v_world;
in vec3 v_normal;
in vec4 v_light;
in vec3 v_cover;
in vec3 v_clear;
in vec3 v_veil;
out vec4 f_colour;

const vec3 DARK = vec3(0.16, 0.125, 0.10);
const vec3 OCHRE = vec3(0.56, 0.40, 0.22);
const vec3 CREAM = vec3(0.70, 0.60, 0.45);
const vec3 TURF = vec3(0.20, 0.21, 0.05);
const vec3 CORALLINE = vec3(0.62, 0.22, 0.36);
const vec3 VIOLET = vec3(0.36, 0.18, 0.46);
const vec3 SPONGE = vec3(0.86, 0.33, 0.06);
const vec3 LEMON = vec3(0.78, 0.62, 0.12);

// Height, and the slope of it in the world, of the relief seen along all three axes.
vec4 carved(vec3 p, vec3 share, out float polyps) {
    vec4 x = texture(u_relief, p.yz), y = texture(u_relief, p.xz), z = texture(u_relief, p.xy);
    polyps = dot(share, vec3(x.a, y.a, z.a));
    vec3 slope = share.x * vec3(0.0, x.yz) + share.y * vec3(y.y, 0.0, y.z) + share.z * vec3(z.yz, 0.0);
    return vec4(dot(share, vec3(x.r, y.r, z.r)), slope);
}

void main() {
    vec3 normal = normalize(v_normal);
    vec3 share = normal * normal;
    share *= share;
    share /= share.x + share.y + share.z;
    float polyps, specks;
    vec4 broad = carved(v_world / 170.0, share, polyps);
    vec4 fine = carved(v_world / 43.0 + 0.3, share, specks);
    float height = 0.6 * broad.x + 0.6 * fine.x;
    float up = normal.z;
    float hollow = v_light.z;
    vec3 slope = 0.055 * broad.yzw + 0.045 * fine.yzw;
    normal = normalize(normal - slope + normal * dot(slope, normal));

    float turf = v_cover.x, algae = v_cover.y, sponge = v_cover.z;
    vec3 stone = mix(DARK, mix(OCHRE, CREAM, clamp(0.5 + 1.2 * algae + 0.3 * fine.x, 0.0, 1.0)),
                     clamp(0.62 + 0.4 * height - 0.35 * hollow, 0.0, 1.0));
    // Pink crusts where light is weak, violet ones deeper in; turf where it is strong.
    float pink = smoothstep(-0.05, 0.22, algae + 0.22 * height - 0.15 * up + 0.10);
    vec3 crust = mix(CORALLINE, VIOLET, smoothstep(-0.1, 0.5, turf + 0.4 * hollow - 0.3 * up));
    stone = mix(stone, crust * (0.8 + 0.5 * height), 0.8 * pink);
    float green = smoothstep(0.0, 0.32, 0.6 * turf + 0.55 * up + 0.25 * broad.x - 0.34);
    stone = mix(stone, TURF * (1.0 + 0.6 * fine.x), 0.8 * green);
    float orange = smoothstep(0.40, 0.50, sponge + 0.30 * specks + 0.1 * height - 0.12 * up);
    vec3 living = mix(SPONGE, LEMON, smoothstep(-0.1, 0.1, turf));
    stone = mix(stone, living * (0.55 + 0.8 * specks), orange);

    float open = clamp(0.85 + 0.4 * height, 0.3, 1.2) * (1.0 - 0.4 * hollow);
    open *= mix(0.6, 1.0, smoothstep(-4.0, 30.0, v_light.w));
    vec3 sun = sunlight_at(v_world.z) * caustics_at(v_world) * v_light.y;
    vec3 shade = light_from(vec3(0.0), v_world.z, normal, 0.0);
    vec3 light = (light_from(sun, v_world.z, normal, 0.1) - shade) + shade * (0.4 + 1.1 * v_light.x);
    f_colour = vec4(EXPOSURE * stone * light * open * v_clear + v_veil, 1.0);
}
