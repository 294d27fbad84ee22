// The page's numbers: one block of bytes, zlib in base64, and references into it.

/** The page's data and what reads its arrays. */
export async function readPage() {
  const page = JSON.parse(document.getElementById('data').textContent);
  const element = document.getElementById('arrays');
  const zipped = bytesOf(element.textContent.trim());
  element.remove();
  const stream = new Blob([zipped]).stream().pipeThrough(new DecompressionStream('deflate'));
  const block = await new Response(stream).arrayBuffer();
  return { page, arrays: new Arrays(block) };
}

function bytesOf(base64) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(base64);
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let k = 0; k < text.length; k++) bytes[k] = text.charCodeAt(k);
  return bytes;
}

const KINDS = { u8: Uint8Array, i16: Int16Array, u16: Uint16Array, u32: Uint32Array };

class Arrays {
  constructor(block) {
    this.block = block;
  }

  /** The values as they are stored. */
  raw({ at, len, kind }) {
    return new KINDS[kind](this.block, at, len);
  }

  /** The values in their unit. */
  reals(ref) {
    const raw = this.raw(ref);
    const reals = new Float32Array(raw.length);
    for (let k = 0; k < raw.length; k++) reals[k] = raw[k] * ref.scale;
    return reals;
  }

  /** Rows of a sparse matrix; each row of a surface's weights sums to one, whatever was rounded. */
  rows({ counts, carriers, weights }) {
    const n = this.raw(counts);
    const start = new Uint32Array(n.length + 1);
    for (let k = 0; k < n.length; k++) start[k + 1] = start[k] + n[k];
    const share = this.reals(weights);
    for (let k = 0; k < n.length; k++) {
      let sum = 0;
      for (let j = start[k]; j < start[k + 1]; j++) sum += share[j];
      for (let j = start[k]; j < start[k + 1]; j++) share[j] /= sum;
    }
    return { start, column: this.raw(carriers), share };
  }
}
