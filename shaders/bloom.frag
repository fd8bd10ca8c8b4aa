// The light that scatters in the eye around what is very bright: one pass of output/target.py.
//   BRIGHT  1: a quarter of the size, of what is brighter than can be shown; 0: of all
//   BLUR    1: a blur along u_step instead
uniform sampler2D u_picture;
uniform vec4 u_source;  // part of the picture, as shares: corner and size
uniform vec2 u_step;    // texels of the picture, or of the blur's direction, as shares

in vec2 v_place;
out vec4 f_colour;

const float LEAST = 1.6;  // light that the filmic curve shows nearly white
const float MOST = 8.0;   // of a glint: a single pixel must not light up the picture

vec3 taken(vec2 aside) {
    vec3 x = texture(u_picture, u_source.xy + u_source.zw * v_place + aside).rgb;
    if (BRIGHT == 1) {
        float strongest = max(x.r, max(x.g, x.b));
        x *= clamp(strongest - LEAST, 0.0, MOST) / max(strongest, 1e-4);
    }
    return x;
}

void main() {
    vec3 x = vec3(0.0);
    if (BLUR == 1) {
        float sum = 0.0;
        for (int k = -8; k <= 8; k++) {
            float weight = exp(-0.5 * float(k * k) / 16.0);
            x += weight * taken(float(k) * u_step);
            sum += weight;
        }
        x /= sum;
    } else {
        for (int k = 0; k < 4; k++)  // each tap is the mean of four texels
            x += 0.25 * taken(u_step * vec2(k % 2 == 0 ? -1.0 : 1.0, k < 2 ? -1.0 : 1.0));
    }
    f_colour = vec4(x, 1.0);
}
