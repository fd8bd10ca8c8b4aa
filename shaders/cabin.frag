// Final colours: of a panel (PANEL 1) or a picture over the sea (2) with premultiplied opacity, or of
// painted metal lit from above (0).
uniform sampler2D u_panel;
uniform float u_opacity;  // of a picture
uniform vec3 u_light;  // of the water around, final colour

in vec4 v_look;
out vec4 f_colour;

#if LINEAR
uniform float u_unit;  // of light on the canvas, as in view.glsl

// The light that becomes a final colour on the canvas: the inverse of sRGB and of the filmic curve
// of resolve.frag, without its care for hue.
vec3 drawn(vec3 colour) {
    vec3 y = pow(clamp(colour, 0.0, 0.95), vec3(2.2));
    vec3 a = 2.51 - 2.43 * y, b = 0.03 - 0.59 * y;
    return u_unit * (sqrt(b * b + 0.56 * a * y) - b) / (2.0 * a);
}
#else
vec3 drawn(vec3 colour) {
    return colour;
}
#endif

void main() {
#if PANEL
    vec4 text = texture(u_panel, v_look.xy);
    vec3 colour = drawn(text.rgb / max(text.a, 1e-3)) * text.a;
#if PANEL == 2
    f_colour = vec4(colour, text.a) * u_opacity;
#else
    // The ground of the instruments ends at the foot of a window, but in the open on a panel.
    f_colour = vec4(colour, text.a) * smoothstep(0.0, 0.08, v_look.y);
#endif
#else
    float up = 0.5 + 0.5 * normalize(v_look.xyz).y;
    f_colour = vec4(drawn((0.2 + 0.8 * up * up) * v_look.w * u_light), 1.0);
#endif
}
