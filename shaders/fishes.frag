#include "optics.glsl"
#include "fishes.glsl"

uniform sampler2D u_skins;  // painted, side by side; alpha is the opacity

centroid in vec3 v_world;
centroid in vec3 v_normal;
centroid in vec3 v_rest;  // distance behind the snout, height, side
centroid in vec3 v_part;  // part, u, v
in float v_identity;
in vec3 v_clear;
in vec3 v_veil;
flat in int v_kind;
flat in float v_fade;
flat in float v_display;

out vec4 f_colour;

const float SHARPEN = -0.6;  // mipmaps alone blur stripes that can still be told apart
const vec2 SCALES = vec2(78.0, 30.0);  // per body length along, from ridge to ridge

// The paint at a place on the body.
vec4 painted(vec2 place) {
    vec4 box = looks[v_kind].skin_box, on = looks[v_kind].skin;
    return texture(u_skins, on.xy + on.zw * clamp(place, box.xy, box.zw), SHARPEN);
}

// Rows of scales, each overlapping the next and a little tilted; they blur away before they alias.
float scales(vec2 place, inout vec3 normal) {
    vec4 coat = looks[v_kind].coat;
    vec2 cell = vec2(place.x, v_part.y) * SCALES;
    vec2 grain = fwidth(cell);
    float off = fract(cell.y) - 0.5;
    cell.x += 0.5 * mod(floor(cell.y), 2.0) + 2.0 * off * off;  // round behind
    float seen = 1.0 - smoothstep(0.25, 0.8, max(grain.x, grain.y));
    // Neither the face nor the tail fin has any.
    seen *= smoothstep(looks[v_kind].eye.x, looks[v_kind].eye.x + 0.12, place.x);
    seen *= 1.0 - smoothstep(looks[v_kind].build.y - 0.02, looks[v_kind].build.y + 0.02, place.x);
    vec2 from_middle = fract(cell) - 0.5;
    normal = normalize(normal + 0.14 * coat.y * seen * vec3(from_middle, 0.3 * from_middle.x));
    return 1.0 + seen * coat.y * coat.x * (0.3 * from_middle.x - 0.4 * dot(from_middle, from_middle));
}

// The rays of a fin run from its root to its edge.
float rays(float count, float at) {
    float seen = 1.0 - smoothstep(0.2, 0.8, fwidth(at * count));
    return 1.0 - 0.26 * looks[v_kind].coat.z * seen * (0.5 + 0.5 * cos(6.2832 * count * at));
}

void main() {
    vec3 view = normalize(u_eye - v_world);
    vec3 normal = normalize(v_normal);
    bool thin = v_part.x > 0.5;
    if (thin && dot(normal, view) < 0.0) normal = -normal;

    vec2 place = v_rest.xy;
    vec4 skin = looks[v_kind].paddle;
    if (v_part.x < 1.5) {
        skin = painted(place);
    } else {
        vec4 rim = looks[v_kind].paddle_rim;
        float to_end = (1.0 - v_part.y) / max(rim.w, 1e-4);
        skin.rgb = mix(rim.rgb, skin.rgb, smoothstep(0.7, 1.0, to_end));
    }
    skin.rgb *= 0.92 + 0.16 * v_identity;
    float gloss = 0.08, spark = 0.0;
    if (thin) {
        skin.rgb *= rays(v_part.x < 1.5 ? 30.0 : 7.0, v_part.z);
        if (v_part.x > 1.5) skin.a = mix(1.0, skin.a, smoothstep(0.0, 0.5, v_part.y));
    } else {
        skin.rgb *= scales(place, normal);
        gloss = looks[v_kind].coat.x * skin.a;
        spark = 1.0 - smoothstep(0.8, 1.0, length(place - looks[v_kind].eye.xy) / looks[v_kind].eye.z);
    }

    vec3 sun = sunlight_at(v_world.z) * caustics_at(v_world);
    vec3 light = light_from(sun, v_world.z, normal, 0.25);
    // What is thin glows with the light that falls on its other side.
    float clear = thin ? 0.5 : 2.0 * (1.0 - skin.a);
    light += clear * sun * max(dot(-normal, SUN), 0.25);
    float facing = max(dot(normal, view), 0.0);
    float mirror = max(dot(normal, normalize(view + SUN)), 0.0);
    vec3 colour = EXPOSURE * skin.rgb * light;
    colour += (gloss * pow(mirror, 38.0) + 3.0 * spark * pow(mirror, 160.0)) * sun;
    // A wet skin mirrors the water around it at grazing angles.
    float rim = 1.0 - facing;
    rim *= rim;
    colour += 0.35 * rim * rim * water_radiance(reflect(-view, normal));
    f_colour = vec4(colour * v_clear + v_veil, skin.a);
}
