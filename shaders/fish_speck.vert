// A fish of a few pixels: a control point a vertex, lit here. With DOT its colour is found here, too.
#include "optics.glsl"
#include "fishes.glsl"
#include "individual.glsl"
#include "speck_light.glsl"

uniform float u_without;     // number of the fish through whose eyes this is, below 0 nobody's
uniform sampler2D u_table;   // control points of recorded frames: see table_place
uniform sampler2D u_places;  // column by vertex, row by species: place on the atlas of skins, -1
                             // if there is no such fin, how far it is moved from its root, or 0

in vec3 a_normal;
in vec3 a_part;  // control point, its root, 1 if it belongs to a thin fin

in vec4 i_place;  // cm, scale
in vec4 i_turn;   // quaternion w, x, y, z
in vec4 i_pose;   // row a, row b, weight of b, identity
in vec3 i_fins;   // mouth, dorsal and ventral fin, tail
in vec4 i_show;   // species, cross-fade, mating colours, number of the fish

#ifdef DOT
centroid out vec4 v_light;      // and its opacity
#else
centroid out vec3 v_sky;        // light from all around
centroid out float v_facing;    // share of the sun's light
flat out vec3 v_sun;
centroid out vec3 v_around;     // what silver mirrors
flat out float v_silver;
out vec2 v_skin;
flat out vec4 v_tone;
#endif
centroid out vec3 v_veil;
#ifdef PASSES
centroid out vec3 v_clear;
#endif
flat out float v_fade;
#ifdef OBJECT_IDS
uniform float u_object_id;  // of fish 0
flat out float v_object_id;
#endif

vec3 control(float point) {
    vec3 a = texelFetch(u_table, table_place(int(point), int(i_pose.x)), 0).xyz;
    vec3 b = texelFetch(u_table, table_place(int(point), int(i_pose.y)), 0).xyz;
    return mix(a, b, i_pose.z);
}

vec3 turned(vec3 v) {
    vec3 t = 2.0 * cross(i_turn.yzw, v);
    return v + i_turn.x * t + cross(i_turn.yzw, t);
}

void main() {
    int kind = int(i_show.x);
    vec4 own = texelFetch(u_places, ivec2(gl_VertexID, kind), 0), coat = looks[kind].coat;
    // A folded fin lies closer to its root; the ring of a dot is wider than the body.
    float out_of_root = own.w > 0.0 ? own.w : mix(i_fins.y, 1.0, coat.w);
    vec3 place = mix(control(a_part.y), control(a_part.x), out_of_root);
    vec3 world = i_place.xyz + turned(i_place.w * place);
    vec3 ray = world - u_eye;
    float distance = length(ray);
    ray /= distance;
    vec3 normal = turned(a_normal);
    bool thin = a_part.z > 0.5;
    if (thin && dot(normal, ray) > 0.0) normal = -normal;
    vec3 day = daylight(world.z), sun = SUNLIGHT * day;
    vec3 sky = mix(SANDLIGHT, SKYLIGHT, 0.5 + 0.5 * normal.z) * day + lamplight_on(world, normal, 0.25);
    if (thin) sky += 0.6 * sun * sunward(-normal);
    vec3 through = clearness(distance);
    sky *= EXPOSURE * through;
    sun *= EXPOSURE * through;
    float silvery = thin ? 0.0 : coat.z;
    float over = exp(u_down.g * (world.z - u_eye.z));
    vec3 around = water_radiance(reflect(ray, platelets(normal, silvery))) * over * through;
    vec4 worn = tone(i_pose.w, kind, i_show.z);
#ifdef DOT
    v_light = speck_light(own.xy, worn, silvery, sky + sun * sunward(normal), around);
#else
    v_sky = sky;
    v_sun = sun;
    v_facing = sunward(normal);
    v_silver = silvery;
    v_around = around;
    v_tone = worn;
    v_skin = own.xy;
#endif
    v_veil = water_radiance(ray) * (1.0 - through) + glow(ray, distance);
#ifdef PASSES
    v_clear = through;
#endif
    v_fade = i_show.y;
#ifdef OBJECT_IDS
    v_object_id = u_object_id + i_show.w;
#endif
    gl_Position = u_projection * u_view * vec4(world, 1.0);
    // Outside: this species has no such fin, or it is the onlooker's own body.
    if (own.z < 0.0 || i_show.w == u_without) gl_Position = vec4(0.0, 0.0, 2.0, 1.0);
}
