// Stone under water: bare rock, and what grows on it in patches.
#include "optics.glsl"

uniform sampler2D u_relief;  // height, its slopes, polyps

in vec3 v_world;
in vec3 v_normal;
in vec4 v_cover;
in float v_above;
in vec3 v_clear;
in vec3 v_veil;
out vec4 f_colour;

const vec3 DARK = vec3(0.10, 0.09, 0.08);
const vec3 PALE = vec3(0.44, 0.39, 0.31);
const vec3 TURF = vec3(0.12, 0.14, 0.05);
const vec3 CORALLINE = vec3(0.42, 0.17, 0.25);
const vec3 SPONGE = vec3(0.62, 0.27, 0.06);

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
    vec4 broad = carved(v_world / 230.0, share, polyps);
    vec4 fine = carved(v_world / 53.0 + 0.3, share, specks);
    float height = 0.6 * broad.x + 0.6 * fine.x;
    vec3 slope = 0.045 * broad.yzw + 0.035 * fine.yzw;
    normal = normalize(normal - slope + normal * dot(slope, normal));

    vec3 stone = mix(DARK, PALE, clamp(0.45 + 0.35 * height - 0.3 * v_cover.x, 0.0, 1.0));
    float pink = smoothstep(0.15, 0.5, v_cover.z + 0.35 * height - 0.5 * max(normal.z, 0.0));
    stone = mix(stone, CORALLINE * (0.75 + 0.4 * height), 0.75 * pink);
    float green = smoothstep(-0.1, 0.55, 0.55 * v_cover.y + 0.6 * normal.z + 0.5 * broad.x - 0.3);
    stone = mix(stone, TURF * (1.0 + 0.5 * fine.x), 0.85 * green);
    float orange = smoothstep(0.85, 1.05, v_cover.w + 0.45 * specks + 0.1 * height);
    stone = mix(stone, SPONGE * (0.7 + 0.6 * specks), orange);

    // Hollows, cracks and the foot see less of the sky.
    float open = clamp(0.8 + 0.35 * height, 0.35, 1.15) * (1.0 - 0.45 * v_cover.x * v_cover.x);
    open *= mix(0.45, 1.0, smoothstep(-4.0, 45.0, v_above));
    vec3 light = light_on(v_world, normal, 0.15) * open;
    f_colour = vec4(EXPOSURE * stone * light * v_clear + v_veil, 1.0);
}
