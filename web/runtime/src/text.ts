/** Contents of a model.txt or a body.txt. */
export type ModelText = string | ArrayBufferView | ArrayBuffer;

export function bytesOfText(text: ModelText): Uint8Array {
  if (typeof text === 'string') return new TextEncoder().encode(text);
  if (ArrayBuffer.isView(text)) return new Uint8Array(text.buffer, text.byteOffset, text.byteLength);
  return new Uint8Array(text);
}
