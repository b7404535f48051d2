/* Unpacks deflated bytes that are stored as text, and numbers that change smoothly from frame to frame. */

export const packing = {
  async bytes(text) {
    const raw = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const stream = new Blob([raw]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  },

  /* Frames of `size` numbers each: stored is how far each is off the straight line through the two before it. */
  motion(bytes, size) {
    const count = bytes.length / 2;
    const out = new Uint16Array(count);
    for (let i = 0; i < count; i++) {
      const folded = bytes[i] | (bytes[count + i] << 8);
      const off = (folded >> 1) ^ -(folded & 1);
      const before = i >= size ? out[i - size] : 0;
      const earlier = i >= 2 * size ? out[i - 2 * size] : 0;
      out[i] = off + 2 * before - earlier;
    }
    return out;
  },
};
