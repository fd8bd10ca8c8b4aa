// The submarine's two headlights: warm beams with soft edges, and the water that they light up.
// Without LIT there are none, and they cost nothing (`shaders.wanted`).
#ifdef LIT
uniform vec3 u_lamps[2];  // cm
uniform vec3 u_beams[2];  // unit vectors along the axes of the beams

const vec3 LAMPLIGHT = vec3(12.0, 9.2, 6.0);  // near a lamp, on its axis
const float HALFWAY = 320.0;                  // cm, where it has spread so far that half is left
const float CLOSE = 120.0;  // cm, nearer things are between the beams, and do not burn out
const float INNER = 0.978, OUTER = 0.891;     // cosines of 12 and 27 degrees: bright, and dark
// Share that a centimetre of water sends to the eye, more of blue, as a sky does.
const vec3 SCATTERED = vec3(1.3, 2.7, 3.8) * 1e-5;
const float GLOW_REACH = 900.0;  // cm, farther off the beams are not seen
const int GLOW_STEPS = 9;

// The light of a lamp at p, and the way back to it.
vec3 lamplight(int k, vec3 p, out vec3 toward) {
    vec3 ray = u_lamps[k] - p;
    float distance = length(ray);
    toward = ray / max(distance, 1e-3);
    float within = clamp((-dot(toward, u_beams[k]) - OUTER) / (INNER - OUTER), 0.0, 1.0);
    within *= within * (3.0 - 2.0 * within);
    float spread = distance / HALFWAY;
    float near = distance * distance;
    within *= 0.12 + 0.88 * near / (near + CLOSE * CLOSE);
    return LAMPLIGHT * within / (1.0 + spread * spread) * clearness(distance);
}

// On a surface.
vec3 lamplight_on(vec3 p, vec3 normal, float wrap) {
    vec3 light = vec3(0.0);
    for (int k = 0; k < 2; ++k) {
        vec3 toward, own = lamplight(k, p, toward);
        light += own * max((dot(normal, toward) + wrap) / (1.0 + wrap), 0.0);
    }
    return light;
}

// On what is lit from all sides alike.
vec3 lamplight_at(vec3 p) {
    vec3 toward;
    return lamplight(0, p, toward) + lamplight(1, p, toward);
}

// What the water before `distance` cm scatters of the beams, seen in a direction.
vec3 glow(vec3 direction, float distance) {
    float far = min(distance, GLOW_REACH);
    vec3 sum = vec3(0.0);
    for (int k = 0; k < GLOW_STEPS; ++k) {
        // Denser near the eye, where the beams are brightest.
        float share = (float(k) + 0.5) / float(GLOW_STEPS);
        float at = far * share * share;
        sum += lamplight_at(u_eye + at * direction) * share * clearness(at);
    }
    return SCATTERED * 2.0 * far / float(GLOW_STEPS) * sum;
}
#else
vec3 lamplight_on(vec3 p, vec3 normal, float wrap) { return vec3(0.0); }
vec3 lamplight_at(vec3 p) { return vec3(0.0); }
vec3 glow(vec3 direction, float distance) { return vec3(0.0); }
#endif
