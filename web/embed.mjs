// Writes text files into a C++ source, for web/pages.
// Usage: node embed.mjs OUT.cpp [FILE...]
import { readFileSync, writeFileSync } from 'node:fs';
import { basename } from 'node:path';

const [out, ...files] = process.argv.slice(2);
const bytesPerChunk = 15000; // compilers may limit a string literal to 65,536 bytes, and every byte may need 4 characters

/** A literal of C++. Bytes other than plain ASCII become octal escapes of three digits. */
function literal(bytes) {
  let text = '';
  for (const byte of bytes) {
    const plain = byte >= 32 && byte < 127 && byte !== 34 && byte !== 92 && byte !== 63;
    text += plain ? String.fromCharCode(byte) : `\\${byte.toString(8).padStart(3, '0')}`;
  }
  return `"${text}"`;
}

let source = '#include "embedded.hpp"\n\nnamespace phynness {\n\n';
files.forEach((file, i) => {
  const bytes = readFileSync(file);
  if (bytes.includes(0)) throw new Error(`${file} contains a zero byte`);
  source += `static const char* const file_${i}[] = {\n`;
  for (let at = 0; at < bytes.length; at += bytesPerChunk) source += `    ${literal(bytes.subarray(at, at + bytesPerChunk))},\n`;
  source += '    nullptr};\n';
});
source += '\nconst EmbeddedFile embedded_files[] = {\n';
files.forEach((file, i) => {
  source += `    {"${basename(file)}", file_${i}},\n`;
});
source += '    {nullptr, nullptr}};\n\n}  // namespace phynness\n';
writeFileSync(out, source);
