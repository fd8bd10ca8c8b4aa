#include "optics.glsl"
#include "show.glsl"
#ifdef FADING
#include "fades.glsl"
#endif

uniform sampler2D u_grain;  // ridges, polyps, pores

in vec3 v_world;
in vec3 v_normal;
in vec4 v_colour;
in vec4 v_grain;
in vec2 v_along;
in vec3 v_sun;
in vec3 v_clear;
in vec3 v_veil;

void main() {
#ifdef FADING
    if (faded(u_fade)) discard;
#endif
    float height = dot(v_grain.xyz, texture(u_grain, v_along).rgb);
    vec3 normal = normalize(v_normal);
    // Which way on the grain the sun is: what rises toward it is darker.
    float toward_x = dot(dFdx(v_world), SUN), toward_y = dot(dFdy(v_world), SUN);
    vec2 sunward = toward_x * dFdx(v_along) + toward_y * dFdy(v_along);
    sunward *= 0.007 * inversesqrt(dot(sunward, sunward) + 1e-12);
    float rise = dot(v_grain.xyz, texture(u_grain, v_along + sunward).rgb) - height;

    vec3 colour = v_colour.rgb * clamp(1.0 + 0.75 * height, 0.25, 1.7);
    float open = v_grain.a * clamp(1.0 + 0.5 * height, 0.4, 1.2);
    vec3 light = light_from(v_sun * clamp(1.0 - 1.6 * rise, 0.2, 2.0), v_world, normal, 0.25) * open;
    // Thin parts and tips glow with the light from behind.
    vec3 view = normalize(v_world - u_eye);
    float behind = max(dot(view, SUN), 0.0);
    light += v_colour.a * (0.16 + 0.5 * behind * behind) * open * v_sun;
    show(vec4(EXPOSURE * colour * light * v_clear + v_veil, 1.0));
}
