// What differs between species; `render/fishes.py` fills it in, in this order.
struct Look {
    vec4 skin;        // place on the atlas of skins: offset and scale of a place on the body
    vec4 skin_box;    // left, bottom, right, top of the skin, body lengths
    vec4 paddle;      // colour and opacity of the paired fins
    vec4 paddle_rim;  // colour of their end, and its share of their length
    vec4 eye;         // distance from the snout, height, radius, body lengths; size of the head
    vec4 coat;        // gloss; how plainly scales and rays of fins show; 1: fins are stiff
    vec4 build;       // length of the recorded fish, cm; where the tail begins, body lengths
    vec4 pectoral;    // cosine and sine of its droop; 1: it is held out like a wing
    vec4 pelvic;
};

layout(std140) uniform Looks {
    Look looks[SPECIES];
};
