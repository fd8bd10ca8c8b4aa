// The relief of encrusted stone, from a texture that repeats.
uniform sampler2D u_relief;  // height, its slopes, polyps

const vec4 RELIEF_SPAN = vec4(3.2, 3.2, 3.2, 2.0);  // of the texture's bytes, about 0
const float RELIEF_CM = 61.0;  // width of the texture

// Height and polyps of the relief seen along all three axes, by their shares, and its slope.
vec2 relief_at(vec3 p, vec3 share, out vec3 slope) {
    vec4 x = share.x * (RELIEF_SPAN * texture(u_relief, p.yz + 0.31) - 0.5 * RELIEF_SPAN);
    vec4 y = share.y * (RELIEF_SPAN * texture(u_relief, p.xz + 0.67) - 0.5 * RELIEF_SPAN);
    vec4 z = share.z * (RELIEF_SPAN * texture(u_relief, p.xy) - 0.5 * RELIEF_SPAN);
    slope = vec3(y.y + z.y, x.y + z.z, x.z + y.z);
    return vec2(x.x + y.x + z.x, x.w + y.w + z.w);
}
