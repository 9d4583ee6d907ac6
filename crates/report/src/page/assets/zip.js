// A ZIP archive of texts, not compressed (PKWARE, APPNOTE 6.3.10).
const CRC = Uint32Array.from({ length: 256 }, (_, n) => { for (let k = 0; k < 8; k++) n = n & 1 ? 0xedb88320 ^ n >>> 1 : n >>> 1; return n; });

// The archive of `[name, text]`, as a Blob.
function zipped(files) {
  const parts = [], index = [];
  let at = 0;
  for (const [name, text] of files) {
    const [path, bytes] = [name, text].map(words => new TextEncoder().encode(words)), crc = ~bytes.reduce((sum, byte) => CRC[(sum ^ byte) & 255] ^ sum >>> 8, ~0) >>> 0;
    // Names in UTF-8; every file of 1 January 1980.
    const common = [20, 0x800, 0, 0, 0x21].flatMap(x => [x & 255, x >> 8]).concat(long(crc), long(bytes.length), long(bytes.length), short(path.length), short(0));
    parts.push(Uint8Array.from([...long(0x04034b50), ...common]), path, bytes);
    index.push(Uint8Array.from([...long(0x02014b50), ...short(20), ...common, ...short(0), ...short(0), ...short(0), ...long(0), ...long(at)]), path);
    at += 30 + path.length + bytes.length;
  }
  const size = index.reduce((sum, part) => sum + part.length, 0);
  const end = [...long(0x06054b50), ...short(0), ...short(0), ...short(files.length), ...short(files.length), ...long(size), ...long(at), ...short(0)];
  return new Blob([...parts, ...index, Uint8Array.from(end)], { type: "application/zip" });
}
const short = x => [x & 255, x >> 8 & 255];
const long = x => [...short(x), ...short(x >>> 16)];
