// The skins of the species, on the body at rest: s from snout to tail, h from belly (-1) to back (1).
uniform int u_pattern;
uniform vec3 u_back;
uniform vec3 u_flank;
uniform vec3 u_belly;
uniform vec3 u_fins;
uniform vec3 u_accent;
uniform vec3 u_eye_spot;  // s, height, radius, body lengths
uniform float u_tail_begin;

vec3 countershaded(float s, float h, float identity) {
    // Fusilier: yellow from the forehead along the upper back into the whole tail.
    float low = mix(0.72, -0.25, smoothstep(0.12, 0.86, s)) + 0.06 * (identity - 0.5);
    vec3 colour = mix(u_belly, u_flank, smoothstep(-0.75, -0.05, h));
    colour = mix(colour, u_back, smoothstep(low - 0.55, low, h) * 0.65);
    colour = mix(colour, u_accent, smoothstep(low - 0.10, low + 0.08, h) * smoothstep(0.03, 0.14, s));
    colour = mix(colour, u_accent, smoothstep(u_tail_begin - 0.05, u_tail_begin + 0.02, s));
    return colour;
}

vec3 striped(float s, float h, vec2 place, float identity) {
    // Emperor angelfish: fine yellow lines that rise toward the tail, mask, pale muzzle, shoulder.
    float rise = place.y - 0.22 * (s - 0.5) + 0.10 * (s - 0.5) * (s - 0.5);
    float wave = 26.0 + 3.0 * identity;
    float line = 0.5 + 0.5 * sin(6.2832 * (rise * wave + 0.35 * sin(9.0 * s + 6.0 * identity)));
    float blur = clamp(fwidth(rise * wave) * 1.3, 0.0, 1.0);
    float stripes = mix(smoothstep(0.35, 0.75, line), 0.46, smoothstep(0.35, 1.0, blur));
    vec3 base = mix(u_belly, mix(u_flank, u_back, smoothstep(0.1, 0.9, h)), smoothstep(-0.9, 0.2, h));
    float body = smoothstep(0.27, 0.31, s + 0.05 * h * h);
    vec3 colour = mix(base, u_accent, stripes * body * 0.92);
    // Shoulder patch, edged in bright blue.
    float shoulder = length(vec2((s - 0.265) / 0.055, (place.y + 0.02) / 0.115));
    colour = mix(colour, vec3(0.02, 0.18, 0.55), 1.0 - smoothstep(1.0, 1.18, shoulder));
    colour = mix(colour, vec3(0.008, 0.010, 0.03), 1.0 - smoothstep(0.82, 1.0, shoulder));
    // Face: pale muzzle, a dark mask through the eye between blue lines.
    float face = 1.0 - smoothstep(0.185, 0.215, s + 0.03 * h);
    vec3 muzzle = mix(vec3(0.42, 0.50, 0.55), vec3(0.75, 0.74, 0.62), smoothstep(0.12, 0.0, s));
    colour = mix(colour, muzzle, face);
    float axis = abs(s - (u_eye_spot.x + 0.015) + 0.22 * (place.y - u_eye_spot.y));
    float mask = 1.0 - smoothstep(0.030, 0.034, axis);
    float rim = 1.0 - smoothstep(0.040, 0.046, axis);
    float upper = smoothstep(-0.07, -0.03, place.y);
    colour = mix(colour, vec3(0.03, 0.28, 0.75), rim * upper * face);
    colour = mix(colour, vec3(0.006, 0.007, 0.02), mask * upper * face);
    // The tail is plain yellow.
    return mix(colour, u_accent, smoothstep(u_tail_begin - 0.02, u_tail_begin + 0.03, s));
}

// Colour of the body; `place` is (s, height) in body lengths.
vec3 skin_colour(vec2 place, float h, float identity) {
    if (u_pattern == 0) return countershaded(place.x, h, identity);
    return striped(place.x, h, place, identity);
}

// Colour of the fins: part 1 dorsal (side > 0) or ventral, part 2 pectoral.
vec3 fin_colour(float s, float edge, float part, float side) {
    if (u_pattern == 0) {
        float yellow = part < 1.5 && side > 0.0 ? 0.85 : 0.0;
        return mix(u_fins, u_accent, yellow);
    }
    vec3 colour = mix(u_flank, u_fins, edge);
    float lines = smoothstep(0.3, 0.7, 0.5 + 0.5 * sin(40.0 * edge));
    colour = mix(colour, u_accent, part < 1.5 ? 0.55 * lines * smoothstep(0.4, 0.9, s) : 0.15);
    return mix(colour, vec3(0.05, 0.35, 0.8), smoothstep(0.90, 0.98, edge) * (part < 1.5 ? 0.8 : 0.0));
}
