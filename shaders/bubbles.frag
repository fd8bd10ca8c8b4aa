// Air in water. Past the critical angle its skin mirrors everything: a silvery rim. Within it one
// sees through, as through a lens that spreads: all that is behind, small and bent outward.
#include "optics.glsl"
#include "show.glsl"

in vec2 v_corner;
in vec3 v_world;
in vec3 v_veil;
in vec3 v_clear;
in float v_strength;
in float v_small;
flat in vec3 v_right;
flat in vec3 v_up;
flat in vec4 v_shape;

const float INDEX = 1.33;  // of water over air
const float WINDOW = 0.66;  // upward component beyond which Snell's window shows the sky

// Radiance that comes from a direction, with the sky and its sun above, sand below.
vec3 seen_along(vec3 way, vec3 sun) {
    vec3 light = water_radiance(way) * (1.0 - 0.35 * smoothstep(0.2, 0.9, -way.z));
    light += 0.24 * sun * smoothstep(WINDOW - 0.1, WINDOW + 0.12, way.z);
    return light + 0.035 * sun * smoothstep(0.25, 0.8, -way.z);
}

void main() {
    // The lower side of a cap is flat; ripples run around.
    vec2 at = v_corner;
    if (at.y < 0.0) at.y *= 1.0 + v_shape.x;
    float two = at.x * at.x - at.y * at.y, three = at.x * (at.x * at.x - 3.0 * at.y * at.y);
    float far = dot(at, at);
    far *= 1.0 + 2.0 * (v_shape.y * two + v_shape.z * three) / max(far, 0.05);
    // A small one fades from its middle, lest its few pixels are taken for edges to be smoothed.
    float soft = max(1.0 - far, 0.0);
    float edge = clamp(2.5 / max(v_shape.w, 1.0), 0.06, 0.9);
    float inside = mix(smoothstep(0.0, edge, soft), soft * soft, v_small);
    far = min(far, 1.0);
    vec3 ray = normalize(v_world - u_eye);
    vec3 outward = at.x * v_right + at.y * v_up;
    vec3 normal = normalize(outward - sqrt(max(1.0 - far, 0.0)) * ray);
    vec3 mirrored = reflect(ray, normal);
    vec3 sun = sunlight_at(v_world.z) + lamplight_at(v_world);

    float r = sqrt(far), whole = smoothstep(0.60, 1.0, INDEX * r);  // Fresnel
    whole = mix(0.04 + 0.96 * whole * whole * whole, 0.5, v_small);
    vec3 mirror = seen_along(mirrored, sun);
    float glint = pow(max(dot(mirrored, SUN), 0.0), 90.0);
    float again = 0.0;
#ifdef CLOSE_UP
    // Refracted in and out, a ray that passes at a share r of the radius turns by twice the angle
    // between its ways in water and in air; beyond 1/INDEX it cannot enter.
    float turn = 2.0 * (asin(min(INDEX * r, 0.999)) - asin(min(r, 1.0 / INDEX)));
    vec3 through = normalize(ray * cos(turn) + outward / max(r, 1e-3) * sin(turn));
    vec3 lens = 0.8 * seen_along(through, sun);
    // The sun in its skin, and again where the far side gathers it.
    again = pow(max(dot(normalize(normal + 0.25 * ray), -SUN), 0.0), 14.0);
#else
    vec3 lens = 0.5 * mirror;
#endif
    mirror += (1.4 * glint + 0.5 * again * far) * sun;
    vec3 light = mix(lens, mirror, whole);
    light = mix(light, 1.2 * water_radiance(ray) + 0.2 * sun, v_small);
    float alpha = mix(mix(0.28, 0.88, whole), 0.6, v_small);
    alpha = max(alpha, min(glint + again * far, 0.8) * (1.0 - v_small));
    show(light * v_clear, v_veil, v_clear, alpha * inside * v_strength);
}
