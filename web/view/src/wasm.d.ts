// phynness.wasm is bundled as bytes (build.mjs).
declare module 'phynness.wasm' {
  const bytes: Uint8Array<ArrayBuffer>;
  export default bytes;
}
