#include "optics.glsl"
#include "fishes.glsl"
#include "skin.glsl"
#include "mouth.glsl"
#define BRIGHTEST 32.0
#include "show.glsl"
#ifdef FADING
#include "fades.glsl"
#endif

uniform sampler2D u_skins;  // painted, side by side; alpha is the opacity

centroid in vec3 v_world;
centroid in vec3 v_normal;
centroid in vec2 v_rest;  // distance behind the snout, height
centroid in vec2 v_part;  // u, v
centroid in vec2 v_skin;  // place on the atlas of skins
centroid in vec3 v_clear;
centroid in vec3 v_veil;
// What a triangle's corners share. Each four numbers more cost a triangle's set-up time.
flat in vec3 v_ahead;    // the way the fish is heading
flat in float v_side;    // -1 on the left half of the body, 1 on the right, 0 on thin fins
flat in vec4 v_tone;     // tint and saturation of this individual
flat in vec3 v_shift;    // by how much its mating colours differ
flat in float v_nick;    // where along the fin its edge is torn, far outside if nowhere
flat in float v_identity;
flat in float v_fade;
#ifndef DISTANT
flat in float v_gape;  // by how much the lower jaw is turned down, rad
#endif
#ifdef CLOSE_UP
flat in vec3 v_live;  // its gaze; how far its gill covers are lifted
flat in vec4 v_scar;  // middle along and across, slant, length
#endif
flat in int v_kind;
flat in vec4 v_day;  // daylight at its depth, and over that at the eye's depth

const vec3 THROAT = vec3(0.025, 0.008, 0.008), FLESH = vec3(0.30, 0.11, 0.09),
           TOOTH = vec3(0.75, 0.74, 0.68), HEALED = vec3(0.42, 0.36, 0.33);
const float SHARPEN = -0.6;  // mipmaps alone blur stripes that can still be told apart

#ifndef DISTANT
// What is inside of a mouth that is open by `angle`, and how plainly it shows: flesh along the
// lips, darkness between, and of a hunter its teeth. `u` is the place along the round of the body.
vec4 inside_mouth(vec2 rest, float u, int kind, float angle) {
    vec2 at = at_mouth(rest, kind);
    float wide = 0.6 * smoothstep(0.0, 0.35, angle) * sqrt(clamp(1.0 - at.x, 0.0, 1.0));
    float sharp = max(fwidth(at.y), 1e-4), edge = wide - abs(at.y);
    vec3 colour = mix(FLESH, THROAT, smoothstep(0.0, 0.4, edge / max(wide, sharp)));
    float teeth = looks[kind].jaws.z;
    if (teeth > 0.0) {
        float tooth = 0.9 * wide * abs(fract(teeth * u) - 0.5);
        colour = mix(colour, TOOTH, 1.0 - smoothstep(-sharp, sharp, edge - tooth));
    }
    return vec4(colour, smoothstep(-sharp, sharp, edge) * min(wide / sharp, 1.0));
}
#endif

void main() {
#ifdef FADING
    if (faded(v_fade)) discard;
#endif
    vec3 view = normalize(u_eye - v_world);
    vec3 normal = normalize(v_normal);
    bool thin = v_side == 0.0;
    if (thin && dot(normal, view) < 0.0) normal = -normal;

    vec4 coat = looks[v_kind].coat;
#ifdef CLOSE_UP
    vec4 box = looks[v_kind].skin_box;
    vec2 aside = (v_rest - looks[v_kind].eye.xy) / looks[v_kind].eye.z;
    float pupil = thin ? 0.0 : max(1.0 - dot(aside, aside), 0.0);
    vec2 per_length = looks[v_kind].cell.zw * frames[4].zw / (box.zw - box.xy);
    vec4 skin = texture(u_skins, v_skin - 0.20 * looks[v_kind].eye.z * pupil * v_live.xy * per_length, SHARPEN);
#else
    vec4 skin = texture(u_skins, v_skin, SHARPEN);
#endif
    vec4 wear = looks[v_kind].wear;
    vec3 off = skin.rgb - wear.rgb;
    skin.rgb += v_shift * (1.0 - smoothstep(0.0, 1.0, dot(off, off) * wear.w));
    skin.rgb = toned(skin.rgb, v_tone);

    // How far a place is a web of skin between rays, and not body.
    float web = thin ? 1.0 : 0.0;
#ifdef DISTANT
    // Scales, eyes and torn edges are too small to be seen.
    const float seen = 0.0, eye = 0.0, inside = 0.0;
    const vec3 relief = vec3(0.0, 0.0, 1.0);
#else
    vec4 eye_spot = looks[v_kind].eye;
    float tail = looks[v_kind].build.y;
    skin.a *= 1.0 - smoothstep(-0.05, 0.05, v_part.x - 0.5 - 9.0 * abs(v_part.y - v_nick));
    web = max(web, smoothstep(tail, tail + 0.06, v_rest.x));
#ifdef CLOSE_UP
    skin.a *= thin ? 1.0 - 0.4 * smoothstep(0.9, 1.0, v_part.x) : 1.0;  // hems of fins are thinnest
#endif
    float face = 1.0 - smoothstep(eye_spot.x + 0.02, eye_spot.x + 0.12, v_rest.x);
    float seen;
    vec3 relief = scales(v_rest, v_part.x, v_identity, coat.y * (1.0 - web) * (1.0 - face), seen);
    skin.rgb *= relief.z;
    vec2 from_eye = (v_rest - eye_spot.xy) / eye_spot.z;
    float eye = thin ? 0.0 : 1.0 - smoothstep(0.75, 1.1, dot(from_eye, from_eye));
    float inside = 0.0;
    if (v_gape > 0.0 && !thin) {
        vec4 within = inside_mouth(v_rest, v_part.x, v_kind, v_gape);
        inside = within.a;
        skin.rgb = mix(skin.rgb, within.rgb, inside);
    }
    vec2 slope = relief.xy + 0.9 * eye * from_eye;
#ifdef CLOSE_UP
    // The edge of the gill cover lifts, and shows a dark slit behind it.
    float level = 1.0 - 2.0 * v_part.x;
    float behind_gill = v_rest.x - eye_spot.x - eye_spot.w * (1.0 - 0.37 * level * level - 0.15 * level);
    float cover = (thin ? 0.0 : step(1e-4, eye_spot.w)) * (1.0 - smoothstep(0.55, 0.8, abs(level)));
    float slit = cover * v_live.z * smoothstep(-0.002, 0.001, behind_gill) * (1.0 - smoothstep(0.004, 0.011, behind_gill));
    slope.x -= 0.35 * cover * v_live.z * smoothstep(-0.05, -0.004, behind_gill) * (1.0 - smoothstep(-0.004, 0.0, behind_gill));
    skin.rgb = mix(skin.rgb, FLESH * 0.35, 0.5 * slit);
    // Where scales were lost the skin healed pale and smooth, with a dark rim.
    vec2 off_scar = vec2(v_rest.x - v_scar.x, 0.4 * (v_part.x - v_scar.y));
    off_scar += v_scar.z * vec2(-off_scar.y, off_scar.x);
    float scar = 1.0 - length(off_scar * vec2(1.0, 4.5) / max(v_scar.w, 1e-4)) - 0.25 * relief.z;
    float healed = smoothstep(-0.1, 0.15, scar) * step(1e-4, v_scar.w);
    skin.rgb = mix(skin.rgb, mix(skin.rgb, HEALED, 0.6) * mix(0.55, 1.0, smoothstep(0.0, 0.3, scar)), 0.8 * healed);
    slope *= 1.0 - 0.7 * healed;
#endif
    vec3 up = v_side * cross(normal, v_ahead);
    normal = normalize(normal - slope.x * v_ahead + slope.y * up);
#endif

    float silver = silver_of(skin.rgb, coat.z * (1.0 - web) * (1.0 - inside));
    vec3 sun = SUNLIGHT * v_day.rgb * (caustics_at(v_world) * sunny(v_world));
    vec3 light = sun * sunward(normal) + lamplight_on(v_world, normal, 0.25);
    light += mix(SANDLIGHT, SKYLIGHT, 0.5 + 0.5 * normal.z) * v_day.rgb;
    // What is thin glows with the light that falls on its other side.
    float clear = max(web * (0.8 - 0.4 * skin.a), 2.0 * (1.0 - skin.a));
    light += clear * sun * sunward(-normal);
#ifdef CLOSE_UP
    // Against the sun it lights up, in its own colour.
    float counter = max(dot(-view, SUN), 0.0);
    counter *= counter;
    light += clear * sun * (0.2 + 0.8 * skin.rgb) * counter * counter;
#endif
    vec3 colour = EXPOSURE * skin.rgb * light * (1.0 - DARK * silver);

    float facing = max(dot(normal, view), 0.0);
    float mirror = max(dot(normal, normalize(view + SUN)), 0.0);
    mirror *= mirror; mirror *= mirror; mirror *= mirror; mirror *= mirror;  // ^16
    float sharp = mirror * mirror;
    float spark = sharp * sharp;
    spark *= spark;
    float gloss = mix(coat.x * (0.35 + 0.65 * seen), 0.06, web) * (1.0 - inside);
    vec3 sheen = sheen_of(facing, relief.x);
    colour += (gloss * sharp * mix(0.2 + 0.8 * skin.rgb, 0.7 * sheen, silver) + 4.0 * eye * spark) * sun;
    // Wet skin mirrors the water around it at grazing angles, silver at all.
    float rim = 1.0 - facing;
    rim *= rim;
    float share = 0.22 * rim * rim + (0.10 + 0.1 * rim) * eye;
    share *= 1.0 - inside;
#ifdef CLOSE_UP
    // A film of slime over all, and platelets whose colours turn with the angle.
    share += (0.10 * rim + 0.015) * (1.0 - web) * (1.0 - inside);
    colour += 0.16 * spark * (1.0 - web) * (1.0 - eye) * sun;
    vec3 film = 0.8 + 0.3 * cos(6.2832 * (1.3 * facing + 0.6 * relief.x + 1.8 * v_rest.y + vec3(0.0, 0.36, 0.68)));
    sheen = mix(sheen, film, silver);
#endif
    vec3 mirrored = reflect(-view, platelets(normal, silver));
    colour += (share + mirroring(skin.rgb, silver, sheen)) * v_day.a * water_radiance(mirrored);
#ifdef CLOSE_UP
    // A wet eye shows the bright surface above it.
    colour += 0.12 * eye * smoothstep(0.45, 0.75, mirrored.z) * (SKYLIGHT + 0.4 * SUNLIGHT) * v_day.rgb;
#endif
#ifdef LIT
    // Lamps are near the eye: what faces it throws their light back, silver and scales most.
    float back = facing * facing;
    back *= back;
    back *= back;
    vec3 beam = lamplight_at(v_world);
    colour += EXPOSURE * (0.3 * silver * back + gloss * back * back * back + eye * spark) * beam;
#endif
    show(colour * v_clear, v_veil, v_clear, skin.a);
}
