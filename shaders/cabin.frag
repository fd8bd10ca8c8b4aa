// Final colours: of a panel with premultiplied opacity, or of painted metal lit from above.
uniform sampler2D u_panel;
uniform vec3 u_light;  // of the water around, final colour

in vec4 v_look;
out vec4 f_colour;

void main() {
#if PANEL
    // The ground of the instruments ends at the foot of a window, but in the open on a panel.
    f_colour = texture(u_panel, v_look.xy) * smoothstep(0.0, 0.08, v_look.y);
#else
    float up = 0.5 + 0.5 * normalize(v_look.xyz).y;
    f_colour = vec4((0.2 + 0.8 * up * up) * v_look.w * u_light, 1.0);
#endif
}
