// Every glTF that is named through `seamwright unwrap` to GLB, judged by readers that are not ours.
//
//     cd FOLDER_WITH_NODE_MODULES   # npm i gltf-validator @gltf-transform/core @gltf-transform/extensions meshoptimizer
//     node .../tests/bench/gltf_roundtrip.mjs SEAMWRIGHT [--ending gltf] [--uv-set N] [--] FILE...
//
// For each file: the Khronos validator may find no error in the result of an input without errors; read by
// @gltf-transform/core, triangle by triangle, every attribute, morph target, joint and weight must be bit-equal but for the
// set of UVs that was written; and the JSON must be equal but for accessors, buffer views, buffers and the primitives' own
// numbers. Images, animations and inverse bind matrices are compared by their bytes. Prints a line a file and a sum.
import { createRequire } from 'node:module';
import { execFileSync } from 'node:child_process';
import { pathToFileURL } from 'node:url';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';

const from = createRequire(path.join(process.cwd(), 'here.js'));
const load = (name) => import(pathToFileURL(from.resolve(name)));
const { NodeIO } = await load('@gltf-transform/core');
const { ALL_EXTENSIONS } = await load('@gltf-transform/extensions');
const { MeshoptDecoder } = await load('meshoptimizer');
const validator = from('gltf-validator');
await MeshoptDecoder.ready;
const io = new NodeIO().registerExtensions(ALL_EXTENSIONS).registerDependencies({ 'meshopt.decoder': MeshoptDecoder });
io.setLogger({ debug() {}, info() {}, warn() {}, error() {} });

const words = process.argv.slice(2);
const option = (name, otherwise) => {
  const at = words.indexOf(name);
  return at < 0 ? otherwise : words.splice(at, 2)[1];
};
const ending = option('--ending', 'glb');
const set = Number(option('--uv-set', '0'));
const extra = option('--flags', '').split(' ').filter((word) => word);
const [program, ...files] = words.filter((word) => word !== '--');
const own = `TEXCOORD_${set}`;

// The JSON of a file and what its validator says.
function json(file) {
  const bytes = fs.readFileSync(file);
  if (bytes.toString('latin1', 0, 4) !== 'glTF') return JSON.parse(bytes.toString('utf8').replace(/^\uFEFF/, ''));
  return JSON.parse(bytes.toString('utf8', 20, 20 + bytes.readUInt32LE(12)));
}

async function errors(file) {
  const folder = path.dirname(file);
  const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {
    uri: path.basename(file),
    maxIssues: 0,
    externalResourceFunction: (uri) => fs.promises.readFile(path.join(folder, decodeURIComponent(uri))),
  });
  const count = {};
  for (const { severity, code } of report.issues.messages) if (severity === 0) count[code] = (count[code] ?? 0) + 1;
  return count;
}

// The tree without what an unwrap may change.
function plain(tree) {
  const copy = structuredClone(tree);
  for (const key of ['accessors', 'bufferViews', 'buffers']) delete copy[key];
  const compression = ['EXT_meshopt_compression', 'KHR_meshopt_compression', 'KHR_draco_mesh_compression'];
  for (const key of ['extensionsUsed', 'extensionsRequired']) {
    copy[key] = (copy[key] ?? []).filter((name) => !compression.includes(name));
    if (!copy[key].length) delete copy[key];
  }
  for (const mesh of copy.meshes ?? []) {
    for (const primitive of mesh.primitives) {
      delete primitive.indices;
      delete primitive.mode; // compared by triangles
      delete primitive.attributes[own];
      for (const lower of Array(set).keys()) delete primitive.attributes[`TEXCOORD_${lower}`];
      const names = (map) => Object.fromEntries(Object.keys(map).map((name) => [name, 0]));
      primitive.attributes = names(primitive.attributes);
      primitive.targets = primitive.targets?.map(names);
      delete primitive.extensions?.KHR_draco_mesh_compression;
      if (primitive.extensions && !Object.keys(primitive.extensions).length) delete primitive.extensions;
    }
  }
  for (const image of copy.images ?? []) for (const key of ['bufferView', 'uri', 'mimeType']) delete image[key];
  for (const skin of copy.skins ?? []) delete skin.inverseBindMatrices;
  for (const animation of copy.animations ?? []) {
    for (const sampler of animation.samplers) for (const key of ['input', 'output']) delete sampler[key];
  }
  for (const node of copy.nodes ?? []) delete node.extensions?.EXT_mesh_gpu_instancing?.attributes;
  return copy;
}

const sorted = (value) =>
  Array.isArray(value) ? value.map(sorted)
  : value && typeof value === 'object' ? Object.fromEntries(Object.keys(value).sort().map((key) => [key, sorted(value[key])]))
  : value;
const same = (a, b) => JSON.stringify(sorted(a)) === JSON.stringify(sorted(b));
const bytesOf = (array) => (array ? Buffer.from(array.buffer, array.byteOffset, array.byteLength).toString('latin1') : '');

// Vertex of each triangle corner; strips and fans as lists, without what only joins their parts.
function corners(primitive) {
  const indices = primitive.getIndices()?.getArray() ?? Uint32Array.from({ length: primitive.getAttribute('POSITION').getCount() }, (_, i) => i);
  const mode = primitive.getMode();
  const out = [];
  const push = (a, b, c) => { if (a !== b && b !== c && c !== a) out.push(a, b, c); };
  if (mode === 4) return Array.from(indices.subarray(0, indices.length - (indices.length % 3)));
  if (mode === 5) for (let i = 0; i + 2 < indices.length; i++) i % 2 ? push(indices[i + 1], indices[i], indices[i + 2]) : push(indices[i], indices[i + 1], indices[i + 2]);
  if (mode === 6) for (let i = 1; i + 1 < indices.length; i++) push(indices[0], indices[i], indices[i + 1]);
  return out;
}

// Numbers of some vertices, in their order.
function gathered(accessor, vertices) {
  const array = accessor.getArray();
  const size = accessor.getElementSize();
  const out = new array.constructor(vertices.length * size);
  vertices.forEach((v, i) => out.set(array.subarray(v * size, v * size + size), i * size));
  return `${accessor.getType()} ${accessor.getNormalized()} ${array.constructor.name} ${bytesOf(out)}`;
}

function differs(a, b, result) {
  const [meshesA, meshesB] = [a.getRoot().listMeshes(), b.getRoot().listMeshes()];
  if (meshesA.length !== meshesB.length) return 'number of meshes';
  for (const [m, mesh] of meshesA.entries()) {
    const [primitivesA, primitivesB] = [mesh.listPrimitives(), meshesB[m].listPrimitives()];
    if (primitivesA.length !== primitivesB.length) return `primitives of mesh ${m}`;
    for (const [p, before] of primitivesA.entries()) {
      const after = primitivesB[p];
      const at = `mesh ${m}, primitive ${p}`;
      if (before.getMode() < 4) { if (after.getMode() !== before.getMode()) return `mode of ${at}`; continue; }
      const [ca, cb] = [corners(before), corners(after)];
      if (ca.length !== cb.length) return `triangles of ${at}: ${ca.length / 3}, ${cb.length / 3}`;
      if (ca.length && !after.getAttribute(own)) return `no ${own} in ${at}`;
      const lower = (name) => /^TEXCOORD_\d+$/.test(name) && Number(name.slice(9)) < set && !before.getAttribute(name);
      const names = (primitive) => primitive.listSemantics().filter((name) => name !== own && !lower(name)).sort();
      if (!same(names(before), names(after))) return `attributes of ${at}: ${names(before)} / ${names(after)}`;
      for (const name of names(before)) {
        if (gathered(before.getAttribute(name), ca) !== gathered(after.getAttribute(name), cb)) return `${name} of ${at}`;
      }
      const [ta, tb] = [before.listTargets(), after.listTargets()];
      if (ta.length !== tb.length) return `morph targets of ${at}`;
      for (const [t, target] of ta.entries()) {
        for (const name of target.listSemantics()) {
          if (gathered(target.getAttribute(name), ca) !== gathered(tb[t].getAttribute(name), cb)) return `target ${t} ${name} of ${at}`;
        }
      }
      result.vertices += before.getAttribute('POSITION').getCount();
      result.added += after.getAttribute('POSITION').getCount() - before.getAttribute('POSITION').getCount();
      result.triangles += ca.length / 3;
      const uv = after.getAttribute(own)?.getArray() ?? [];
      for (const x of uv) if (!(x >= 0 && x <= 1)) return `a UV of ${at} outside of the square`;
    }
  }
  const samplers = (document) => document.getRoot().listAnimations().flatMap((x) => x.listSamplers()).map((s) => bytesOf(s.getInput()?.getArray()) + bytesOf(s.getOutput()?.getArray()));
  if (!same(samplers(a), samplers(b))) return 'animations';
  const binds = (document) => document.getRoot().listSkins().map((skin) => bytesOf(skin.getInverseBindMatrices()?.getArray()));
  if (!same(binds(a), binds(b))) return 'inverse bind matrices';
  const images = (document) => document.getRoot().listTextures().map((texture) => bytesOf(texture.getImage()));
  if (!same(images(a), images(b))) return 'images';
  return '';
}

const sum = { files: 0, same: 0, refused: 0, unjudged: 0, invalid: 0, vertices: 0, added: 0, triangles: 0, bytesBefore: 0, bytesAfter: 0 };
const kinds = { skins: 0, targets: 0, animations: 0, images: 0, quantised: 0, interleaved: 0 };
const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'roundtrip-'));
let failed = 0;
for (const file of files) {
  sum.files += 1;
  const out = path.join(folder, `${sum.files}`, `out.${ending}`);
  fs.mkdirSync(path.dirname(out));
  const say = (text) => console.log(`${file}: ${text}`);
  try {
    execFileSync(program, ['unwrap', file, '-o', out, '-q', '--rays', '16', '--uv-set', `${set}`, ...extra], { stdio: ['ignore', 'pipe', 'pipe'] });
  } catch (e) {
    if (e.status !== 5 || !fs.existsSync(out)) {
      sum.refused += 1;
      say(`refused (${e.status}): ${String(e.stderr).trim().split('\n').at(-1)}`);
      continue;
    }
  }
  const result = { vertices: 0, added: 0, triangles: 0 };
  let problem;
  let original;
  try {
    original = await io.read(file);
  } catch (e) {
    sum.unjudged += 1;
    say(`written, but the judge cannot read the input: ${e.message}`);
    continue;
  }
  try {
    const [before, after] = [await errors(file), await errors(out)];
    // What is wrong with the input may show elsewhere; the file is judged by the reader then.
    const fresh = Object.keys(before).length ? [] : Object.keys(after);
    sum.invalid += Object.keys(before).length > 0;
    const [treeBefore, treeAfter] = [json(file), json(out)];
    const keep = extra.includes('--keep');
    problem = fresh.length ? `new errors ${fresh}`
      : !keep && !same(plain(treeBefore), plain(treeAfter)) ? 'JSON'
      : keep ? '' : differs(original, await io.read(out), result);
    kinds.skins += (treeBefore.skins ?? []).length > 0;
    kinds.animations += (treeBefore.animations ?? []).length > 0;
    kinds.images += (treeBefore.images ?? []).length > 0;
    kinds.targets += (treeBefore.meshes ?? []).some((mesh) => mesh.primitives.some((p) => p.targets));
    kinds.quantised += (treeBefore.extensionsUsed ?? []).some((name) => /quantization|meshopt/.test(name));
    kinds.interleaved += (treeBefore.bufferViews ?? []).some((view) => view.byteStride > 16);
  } catch (e) {
    problem = `cannot be read: ${e.message}`;
  }
  for (const key of ['vertices', 'added', 'triangles']) sum[key] += result[key];
  sum.bytesBefore += fs.statSync(file).size;
  sum.bytesAfter += fs.statSync(out).size;
  if (problem) { failed += 1; say(`DIFFERS: ${problem} (${out})`); } else { sum.same += 1; say(`same, ${result.triangles} triangles, ${result.vertices} vertices and ${result.added} copies`); }
}
console.log(JSON.stringify({ ...sum, differing: failed, with: kinds }));
if (!failed) fs.rmSync(folder, { recursive: true });
process.exit(failed ? 1 : 0);
