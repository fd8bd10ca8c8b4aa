// The share of the sun that reaches a point past all that stands (SUN_MAP) and swims (FISH_MAP),
// from maps of the distance to the sun (`sun_shadows.py`). Without them nothing is in the way.
#ifdef SUN_MAP
uniform sampler2DShadow u_sun_map;
uniform mat4 u_sun_view;  // world to the map, 0 to 1

const float LIFT_OFF_CM = 3.0;  // toward the sun, so that nothing shades itself
const float FILL = 0.22;        // water scatters so much light forward that no shadow is black

// Lit share of a place on a map; beside the map all is lit.
float passed(sampler2DShadow map, vec3 q, float soft) {
    vec2 off = abs(2.0 * q.xy - 1.0);
    float beside = smoothstep(0.85, 1.0, max(off.x, off.y));
    q.z = clamp(q.z, 0.0, 1.0);
#ifdef FISH_MAP
    vec2 a = soft / vec2(textureSize(map, 0));
    float lit = 0.25 * (textureLod(map, q + vec3(a.x, 0.4 * a.y, 0.0), 0.0)
        + textureLod(map, q + vec3(-0.4 * a.x, a.y, 0.0), 0.0)
        + textureLod(map, q + vec3(-a.x, -0.4 * a.y, 0.0), 0.0)
        + textureLod(map, q + vec3(0.4 * a.x, -a.y, 0.0), 0.0));
#else
    float lit = textureLod(map, q, 0.0);
#endif
    return max(lit, beside);
}
#endif

#ifdef FISH_MAP
uniform sampler2DShadow u_fish_map;
uniform mat4 u_fish_view;
#endif

// Without what is scattered.
float unshaded(vec3 p) {
#ifdef SUN_MAP
    p += LIFT_OFF_CM * u_sun;
    float lit = passed(u_sun_map, (u_sun_view * vec4(p, 1.0)).xyz, 1.5);
#ifdef FISH_MAP
    lit *= passed(u_fish_map, (u_fish_view * vec4(p, 1.0)).xyz, 1.2);
#endif
    return lit;
#else
    return 1.0;
#endif
}

float sunny(vec3 p) {
#ifdef SUN_MAP
    return mix(FILL, 1.0, unshaded(p));
#else
    return 1.0;
#endif
}
