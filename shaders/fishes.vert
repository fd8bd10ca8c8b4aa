// A fish: two rows of control points mixed, the surface evaluated from its table (SMC §7.2).
#include "optics.glsl"
#include "fishes.glsl"
#include "individual.glsl"
#include "mouth.glsl"

uniform float u_without;     // number of the fish through whose eyes this is, below 0 nobody's
uniform sampler2D u_table;     // control points of recorded frames: see table_place
uniform sampler2D u_vertices;  // column by vertex, row by species: place on the skin, first
                               // control point of the 3×3 or -1 for none, place along the patch

in vec3 a_u;     // weights across ...
in vec3 a_v;     // ... and along
in vec3 a_du;    // their slopes
in vec3 a_dv;
in vec4 a_part;  // part, u, side, control points in a row

in vec4 i_place;     // cm, scale
in vec4 i_turn;      // quaternion w, x, y, z
in vec4 i_pose;      // row a, row b, weight of b, identity
in vec4 i_pectoral;  // left and right sweep, left and right lift
in vec3 i_fins;      // mouth, spines of dorsal and ventral fin, tail
in vec4 i_wave;      // soft rays; amplitude times sine and cosine of the wave; pelvic fins
in vec3 i_bend;      // twist of the left and right pectoral fin; lag of the tail
in vec4 i_show;      // species, cross-fade, mating colours, number of the fish

// Centroid: at an edge multisampling would else ask for values outside the triangle.
centroid out vec3 v_world;
centroid out vec3 v_normal;
centroid out vec2 v_rest;
centroid out vec2 v_part;
centroid out vec2 v_skin;
centroid out vec3 v_clear;  // haze changes so slowly that the vertices suffice
centroid out vec3 v_veil;
flat out vec3 v_ahead;
flat out float v_side;
flat out vec4 v_tone;
flat out vec3 v_shift;
flat out float v_nick;
flat out float v_identity;
flat out float v_fade;
#ifndef DISTANT
flat out float v_gape;  // by how much the lower jaw is turned down, rad
#endif
#ifdef CLOSE_UP
flat out vec3 v_live;  // its gaze; how far its gill covers are lifted
flat out vec4 v_scar;
#endif
flat out int v_kind;
flat out vec4 v_day;  // daylight at its depth, and over that at the eye's depth
#ifdef OBJECT_IDS
uniform float u_object_id;  // of fish 0
flat out float v_object_id;
#endif

const float WING_SPREAD = 0.95, WING_BEAT = 0.2;  // rad that a wing stands out; its share of the beat
const float BEHIND = 3.0;  // behind its tip nothing moves, lengths of the mouth
const float JOINT = 0.25;  // of the jaws behind the corner of the mouth, lengths of the mouth
const float LEAN = 0.35;  // of a paddle's plane, outwards
const vec2 PELVIC_SWEEP = vec2(0.08, 0.5);  // rad, of a folded and of a spread pelvic fin, and ...
const vec2 PELVIC_LIFT = vec2(0.45, -0.5);  // ... above its rest: share of its droop; rad
const float WAVE = 6.2832 * 1.15;  // rad, of the wave from the front to the rear of a fin's base
const float BEHIND_DORSAL = 1.5;   // rad, by which the wave of the ventral fin lags
const float SPINES = 0.25;  // amplitude of the wave in the spines, over that in the soft rays
const float TWISTED = 0.4;  // of its root, over the twist of a pectoral fin's tip
const float RIPPLE = 0.6;   // of the tail's edge, over the wave of dorsal and ventral fin
const vec2 TAIL_WAVE = vec2(2.5, 3.5);  // rad, of the ripple along the tail and down its edge
const float MARGINS = 0.5;  // stiffness of the first rays of the tail, above and below
const int HALF = 189;       // control points of a half of the body
const float RAKE = 0.8;     // how far the rays of a folded fin turn to the rear

vec3 control(int point) {
    point = min(point, CONTROL_POINTS - 1);
    vec3 a = texelFetch(u_table, table_place(point, int(i_pose.x)), 0).xyz;
    vec3 b = texelFetch(u_table, table_place(point, int(i_pose.y)), 0).xyz;
    return mix(a, b, i_pose.z);
}

vec3 turned(vec3 v) {
    vec3 t = 2.0 * cross(i_turn.yzw, v);
    return v + i_turn.x * t + cross(i_turn.yzw, t);
}

// Where the body heads at a control point of a flank, x and z: along the middle of both flanks.
vec2 heading(int point) {
    int across = point < HALF ? point + HALF : point - HALF;
    vec3 before = control(point - 1) + control(across - 1);
    return normalize((before - control(point + 1) - control(across + 1)).xz);
}

vec3 yawed(vec3 v, vec2 ahead) {
    return vec3(v.x * ahead.x - v.z * ahead.y, v.y, v.x * ahead.y + v.z * ahead.x);
}

#ifndef DISTANT
// Turn the lower jaw down and the upper one up a little, both less the farther behind they are, and
// draw in what is between them.
void open_mouth(inout vec3 place, inout vec3 normal) {
    vec4 mouth = looks[v_kind].mouth;
    float reach = mouth.z - mouth.x, size = looks[v_kind].build.x;
    vec2 at = at_mouth(v_rest, v_kind);
    float lower = 1.0 - smoothstep(-1.0, 1.0, at.y);
    float jaw = 1.0 - smoothstep(0.8, BEHIND, at.x);
    float snout = 1.0 - smoothstep(0.0, BEHIND, at.x);
    float angle = v_gape * mix(0.3 * snout, -jaw, lower);
    mat2 turn = mat2(cos(angle), sin(angle), -sin(angle), cos(angle));
    vec2 arm = size * vec2(mouth.z + JOINT * reach - v_rest.x, v_rest.y - mouth.w);
    place.xy += turn * arm - arm;
    float between = 4.0 * lower * (1.0 - lower) * (1.0 - smoothstep(0.0, 1.0, at.x));
    place -= normal * size * reach * v_gape * between;
    normal.xy = turn * normal.xy;
}
#endif

// Fold the rays of a dorsal or ventral fin to the rear, and let a wave run along it. `root` is the
// foot of a ray, and `base` the way from one foot to the next.
void move_fin(vec3 root, vec3 base, float side, float stiff, inout vec3 place, inout vec3 ray, inout vec3 along) {
    float spiny = side > 0.0 ? looks[v_kind].rays.x : looks[v_kind].rays.y;
    float soft = smoothstep(-0.1, 0.25, v_part.y - spiny);
    float erect = mix(mix(i_fins.y, i_wave.x, soft), 1.0, stiff), height = length(ray);
    vec3 right = cross(ray, base);
    right *= side / max(length(right), 1e-6);
    vec3 rear = RAKE * sqrt(max(1.0 - erect * erect, 0.0)) * base / max(length(base), 1e-6);
    vec3 change = along - base;  // of the ray from one to the next
    along = base + erect * change + dot(ray, change) / max(height, 1e-6) * rear;
    ray = erect * ray + height * rear;
    float phase = WAVE * v_part.y + (side > 0.0 ? 0.0 : BEHIND_DORSAL);
    vec2 swing = height * min(erect, 1.0) * (1.0 - stiff) * mix(SPINES, 1.0, soft) * i_wave.yz;
    ray += (swing.x * cos(phase) - swing.y * sin(phase)) * right;
    along -= v_part.x * WAVE * (swing.x * sin(phase) + swing.y * cos(phase)) * right;
    place = root + v_part.x * ray;
}

// Let the edge of the tail lag behind its stroke and ripple, most in the middle.
void bend_tail(float soft, inout vec3 place, inout vec3 down, inout vec3 along) {
    float begin = looks[v_kind].build.y, way = (v_rest.x - begin) / (1.0 - begin);
    if (way <= 0.0) return;
    float size = looks[v_kind].build.x * (1.0 - begin);
    soft *= looks[v_kind].rays.z;  // a whip is no fin
    float margin = 2.0 * a_part.y - 1.0, middle = soft * (1.0 - MARGINS * margin * margin);
    float phase = TAIL_WAVE.x * way - TAIL_WAVE.y * margin;
    vec2 wave = RIPPLE * mat2(cos(phase), -sin(phase), -sin(phase), -cos(phase)) * i_wave.yz;
    float aside = i_bend.z + wave.x;  // and wave.y is its slope by the phase
    vec3 ahead = normalize(vec3(-along.x, 0.0, -along.z));
    vec3 right = vec3(-ahead.z, 0.0, ahead.x);
    float rearwards = middle * way * (2.0 * aside + TAIL_WAVE.x * way * wave.y);
    float across = TAIL_WAVE.y * middle * wave.y + 2.0 * MARGINS * soft * margin * aside;
    down -= (rearwards * dot(down, ahead) + 2.0 * size * way * way * across) * right;
    along -= rearwards * dot(along, ahead) * right;
    place += size * way * way * middle * aside * right;
}

void main() {
    v_kind = int(i_show.x);
    v_fade = i_show.y;
    vec4 own = texelFetch(u_vertices, ivec2(gl_VertexID, v_kind), 0);
    vec4 build = looks[v_kind].build;
    float stiff = looks[v_kind].coat.w;
    vec3 place = vec3(0.0), along_u = vec3(0.0), along_v = vec3(0.0);
    vec3 root = vec3(0.0), foot = vec3(0.0);
    int base = int(own.z), row = int(a_part.w);
    float side = a_part.z;
    v_part = vec2(a_part.y, own.w);
    v_rest = own.xy;
    if (a_part.x < 1.5) {
        for (int i = 0; i < 3; ++i) {
            if (a_u[i] == 0.0 && a_du[i] == 0.0) continue;
            vec3 across = vec3(0.0), slope = vec3(0.0);
            for (int j = 0; j < 3; ++j) {
                if (a_v[j] == 0.0 && a_dv[j] == 0.0) continue;
                vec3 c = control(base + i * row + j);
                across += a_v[j] * c;
                slope += a_dv[j] * c;
            }
            if (i == 0) {
                root = across;
                foot = slope;
            }
            place += a_u[i] * across;
            along_u += a_du[i] * across;
            along_v += a_u[i] * slope;
        }
        if (a_part.x < 0.5) {
            // The tail spreads, most at its edge.
            place.y *= 1.0 + i_fins.z * (1.0 - stiff) * smoothstep(build.y, 1.0, v_rest.x);
            bend_tail(1.0 - stiff, place, along_u, along_v);
        } else {
            move_fin(root, foot, side, stiff, place, along_u, along_v);
        }
    } else {
        // A paired fin turns about its root: it trails behind and is spread by its sweep.
        bool pelvic = a_part.x > 2.5;
        vec4 paddle = pelvic ? looks[v_kind].pelvic : looks[v_kind].pectoral;
        bool wing = paddle.z > 0.5;
        float sweep = side < 0.0 ? i_pectoral.x : i_pectoral.y;
        float lift = side < 0.0 ? i_pectoral.z : i_pectoral.w;
        if (pelvic) {
            float spread = wing ? 0.4 : i_wave.w, droop = atan(paddle.y, paddle.x);
            sweep = mix(PELVIC_SWEEP.x, PELVIC_SWEEP.y, spread);
            lift = wing ? 0.0 : mix(PELVIC_LIFT.x * droop, PELVIC_LIFT.y, spread);
        }
        float beat = sweep * (0.6 + 0.55 * a_part.y);
        float bend = wing ? WING_SPREAD + WING_BEAT * beat : beat;
        vec3 back = vec3(-paddle.xy, 0.0);
        vec3 across = wing ? vec3(1.0, 0.0, 0.0) : vec3(-paddle.y, paddle.x, 0.0);
        back = back * cos(lift) + vec3(back.y, -back.x, 0.0) * sin(lift);
        across = across * cos(lift) + vec3(across.y, -across.x, 0.0) * sin(lift);
        back = back * cos(bend) + vec3(0.0, 0.0, side * sin(bend));
        across = normalize(across + vec3(0.0, 0.0, wing ? 0.0 : LEAN * side));
        if (!wing && !pelvic) {
            float twist = (side < 0.0 ? i_bend.x : i_bend.y) * mix(TWISTED, 1.0, a_part.y);
            // The way of the blade as it sweeps.
            vec3 forwards = normalize(side * cross(across, back));
            across = cos(twist) * across + sin(twist) * forwards;
        }
        vec2 ahead = heading(base);
        back = yawed(back, ahead);
        across = yawed(across, ahead);
        vec3 socket = yawed(looks[v_kind].roots[int(pelvic)].xyz * vec3(1.0, 1.0, side), ahead);
        place = control(base) + build.x * (socket + own.x * back + own.y * across);
        along_u = back;
        along_v = across;
    }
    vec3 normal = cross(along_u, along_v);
    // At the snout all control points of a row are one: the normal is the way ahead.
    normal = dot(normal, normal) > 1e-8 ? normalize(normal) : vec3(1.0, 0.0, 0.0);
    if (a_part.x < 0.5) normal *= -side;  // outward
#ifndef DISTANT
    bool head = a_part.x < 0.5 && at_mouth(v_rest, v_kind).x < BEHIND;
    v_gape = head ? opening(i_fins.x, v_kind) : 0.0;
    if (v_gape > 0.0) open_mouth(place, normal);
#endif
    v_normal = turned(normal);
    v_world = i_place.xyz + turned(i_place.w * place);
    v_identity = i_pose.w;
    v_ahead = turned(vec3(1.0, 0.0, 0.0));
    v_side = a_part.x < 0.5 ? side : 0.0;
    v_tone = tone(v_identity, v_kind, i_show.z);
    v_shift = max(i_show.z, 0.0) * looks[v_kind].show.rgb;
    v_nick = a_part.x == 1.0 && side > 0.0 ? nick(v_identity, v_kind) : 9.0;
#ifdef CLOSE_UP
    // Water that its mouth took in leaves when it shuts.
    v_live = vec3(gaze(v_identity, side), 1.0 - smoothstep(0.0, 0.35, i_fins.x));
    v_scar = scar(v_identity, v_kind);
    v_scar.w *= step(0.5, abs(v_side)) * step(0.0, side * (fract(7.7 * v_identity) - 0.5));
#endif
    v_day = vec4(daylight(i_place.z), exp(u_down.g * (i_place.z - u_eye.z)));
    vec2 skin = v_rest + displaced(v_rest, v_part.x, v_identity, v_kind);
    if (a_part.x < 0.5) skin = on_body(skin, v_kind);
    else if (a_part.x < 1.5) skin = on_fin(v_part.yx, side > 0.0 ? 0 : 1);
    else skin = on_fin(v_part, a_part.x < 2.5 ? 2 : 3);
    v_skin = looks[v_kind].cell.xy + looks[v_kind].cell.zw * skin;
    vec3 ray = v_world - u_eye;
    float distance = length(ray);
    v_clear = clearness(distance);
    v_veil = water_radiance(ray / distance) * (1.0 - v_clear) + glow(ray / distance, distance);
#ifdef OBJECT_IDS
    v_object_id = u_object_id + i_show.w;
#endif
    gl_Position = u_projection * u_view * vec4(v_world, 1.0);
    // Outside: this species has no such fin, or it is the onlooker's own body.
    if (base < 0 || i_show.w == u_without) gl_Position = vec4(0.0, 0.0, 2.0, 1.0);
}
