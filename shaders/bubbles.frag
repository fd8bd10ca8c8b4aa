// Air in water: past the critical angle its skin mirrors everything, a silvery rim about a centre
// that shows the water behind it, darker.
#include "optics.glsl"
#include "show.glsl"

uniform mat4 u_view;

in vec2 v_corner;
in vec3 v_world;
in vec3 v_veil;
in vec3 v_clear;
in float v_strength;
in float v_small;

void main() {
    float square = dot(v_corner, v_corner);
    // A small one fades from its middle, lest its few pixels are taken for edges to be smoothed.
    float soft = max(1.0 - square, 0.0);
    float inside = mix(1.0 - smoothstep(0.80, 1.0, square), soft * soft, v_small);
    vec3 ray = normalize(v_world - u_eye);
    vec3 right = vec3(u_view[0][0], u_view[1][0], u_view[2][0]);
    vec3 up = vec3(u_view[0][1], u_view[1][1], u_view[2][1]);
    vec3 normal = v_corner.x * right + v_corner.y * up - sqrt(max(1.0 - square, 0.0)) * ray;
    normal = normalize(normal);  // beside the middle of the picture they are not at right angles
    vec3 mirrored = reflect(ray, normal);
    vec3 sun = sunlight_at(v_world.z) + lamplight_at(v_world);
    // Mirrored from above it is the sky in Snell's window.
    vec3 light = water_radiance(mirrored);
    light += 0.22 * sun * smoothstep(0.55, 0.80, mirrored.z);
    light += 1.5 * sun * pow(max(dot(mirrored, SUN), 0.0), 60.0);
    // What the sun sends through it lights its lower edge.
    light += 0.35 * sun * pow(max(dot(normal, -SUN), 0.0), 6.0) * square;
    light = mix(light, 1.3 * water_radiance(ray) + 0.26 * sun, v_small);
    float rim = mix(smoothstep(0.30, 0.62, square), 0.55, v_small);
    float alpha = mix(0.30, 0.95, rim);
    vec3 colour = mix(0.45 * light, light, rim);
    show(vec4(colour * v_clear + v_veil, alpha * inside * v_strength));
}
