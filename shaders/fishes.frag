#include "optics.glsl"
#include "skin.glsl"

in vec3 v_world;
in vec3 v_normal;
in vec4 v_rest;
in vec3 v_part;
in float v_identity;
in float v_fade;

out vec4 f_colour;

const float PI = 3.14159265;

// The eye: pupil, iris, a dark ring; mixed over the skin.
vec3 with_eye(vec3 skin, vec2 place, out float gloss) {
    float d = length(place - u_eye_spot.xy) / u_eye_spot.z;
    vec3 iris = u_pattern == 0 ? vec3(0.62, 0.60, 0.52) : vec3(0.55, 0.38, 0.08);
    vec3 colour = mix(vec3(0.004), iris, smoothstep(0.50, 0.60, d));
    colour = mix(colour, vec3(0.02), smoothstep(0.86, 0.98, d));
    float inside = 1.0 - smoothstep(0.98, 1.08, d);
    gloss = inside;
    return mix(skin, colour, inside);
}

void main() {
    vec3 to_eye = u_eye - v_world;
    float distance = length(to_eye);
    vec3 view = to_eye / distance;
    vec3 normal = normalize(v_normal);
    if (dot(normal, view) < 0.0) normal = -normal;

    vec2 place = vec2(-v_rest.x, v_rest.y);
    vec3 albedo;
    float alpha = 1.0, shine = 0.0, gloss = 0.0, through = 0.0;
    if (v_part.x < 0.5) {
        float h = cos(PI * v_part.y);
        albedo = skin_colour(place, h, v_identity);
        float tail = smoothstep(u_tail_begin + 0.01, u_tail_begin + 0.05, place.x);
        // Scales: rows set like tiles, each a little tilted; they blur away with distance.
        vec2 cell = vec2(place.x * 78.0, v_part.y * 30.0);
        cell.x += 0.5 * mod(floor(cell.y), 2.0);
        float seen = (1.0 - smoothstep(0.25, 0.8, max(fwidth(cell.x), fwidth(cell.y)))) * (1.0 - tail);
        vec2 in_cell = fract(cell) - 0.5;
        albedo *= 1.0 + seen * (0.16 * in_cell.x - 0.22 * dot(in_cell, in_cell));
        normal = normalize(normal + seen * 0.22 * vec3(in_cell.x, in_cell.y, 0.3 * in_cell.x));
        albedo = with_eye(albedo, place, gloss);
        // The gill cover's edge and the mouth.
        float gill = abs(place.x - 0.205 - 0.05 * (1.0 - h * h));
        albedo *= 1.0 - 0.35 * (1.0 - smoothstep(0.0, 0.008, gill)) * smoothstep(0.8, 0.5, abs(h));
        float mouth = abs(place.y + 0.012 + 0.25 * place.x) / 0.006;
        albedo *= 1.0 - 0.6 * (1.0 - smoothstep(0.5, 1.2, mouth)) * (1.0 - smoothstep(0.018, 0.03, place.x));
        albedo *= 0.94 + 0.12 * v_identity;
        shine = mix(u_pattern == 0 ? 0.55 : 0.22, 0.08, tail);
        through = 0.35 * tail;
        alpha = mix(1.0, 0.93, tail);
        float rays = 0.5 + 0.5 * sin(v_part.y * 110.0);
        albedo *= 1.0 - 0.22 * tail * rays;
    } else {
        float edge = v_part.y;
        albedo = fin_colour(place.x, edge, v_part.x, v_rest.w);
        float rays = 0.5 + 0.5 * sin(v_part.z * (v_part.x < 1.5 ? 120.0 : 42.0));
        float fine = 1.0 - smoothstep(0.02, 0.08, fwidth(v_part.z));
        albedo *= 1.0 - 0.28 * rays * fine;
        alpha = v_part.x < 1.5 ? mix(0.97, 0.72, edge) : mix(0.75, 0.45, edge);
        through = 0.55;
        shine = 0.08;
    }

    vec3 light = light_on(v_world, normal, 0.25);
    // Thin fins glow with the light that falls on their other side.
    light += through * sunlight_at(v_world.z) * max(dot(-normal, SUN), 0.25 * through);
    vec3 halfway = normalize(view + SUN);
    float glint = pow(max(dot(normal, halfway), 0.0), 38.0) * shine;
    float spark = pow(max(dot(normal, halfway), 0.0), 160.0) * gloss * 3.0;
    float rim = pow(1.0 - max(dot(normal, view), 0.0), 4.0);
    vec3 colour = albedo * light * 0.62;
    colour += (glint + spark) * sunlight_at(v_world.z) * caustics_at(v_world);
    // A wet skin mirrors the water around it at grazing angles.
    colour += 0.35 * rim * water_radiance(reflect(-view, normal));
    f_colour = vec4(through_water(colour, -view, distance), alpha * v_fade);
}
