// The page's own code in node: node web_node.js MODULE.wasm MESH.obj OUT.obj
'use strict';
const { readFileSync, writeFileSync } = require('fs');
const Obj = require('../docs/web/obj.js');
const seamwright = require('../docs/web/seamwright.js');

const [wasm, mesh, out] = process.argv.slice(2);
const bytes = readFileSync(wasm);
const imports = WebAssembly.Module.imports(new WebAssembly.Module(bytes));
if (imports.length) throw new Error(`the module imports ${imports.map((i) => i.name)}`);
const obj = Obj.read(readFileSync(mesh));
const start = performance.now();
const result = seamwright(bytes).unwrap(obj, {});
const seconds = ((performance.now() - start) / 1000).toFixed(1);
writeFileSync(out, Obj.write(obj, result.uv));
console.log(`node: ${bytes.length} bytes without imports, ${obj.starts.length - 1} polygons, ${result.charts} charts, ${seconds} s`);
