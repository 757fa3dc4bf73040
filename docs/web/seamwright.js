// The C interface (core/ffi/include/seamwright.h) as a WebAssembly module without imports, called with typed arrays.
// One function, complete in itself, so that its text can run in a worker.
'use strict';

// Bytes of the module in, { version, unwrap } out.
function seamwright(bytes) {
    const SCRATCH = 13, INTERFACE = 1;
    const PAGE = 65536;
    const core = new WebAssembly.Instance(new WebAssembly.Module(bytes), {}).exports;
    if (core.seamwright_interface() !== INTERFACE) throw new Error('the module is not the one of this page');
    const memory = core.memory;
    let free = core.__heap_base.value;

    // Memory is handed out upwards from the module's own; a call begins at its start again.
    function take(size) {
        const at = Math.ceil(free / 16) * 16;
        free = at + size;
        const missing = free - memory.buffer.byteLength;
        if (missing > 0) {
            try {
                memory.grow(Math.ceil(missing / PAGE));
            } catch {
                throw new Error(`the mesh needs ${Math.ceil(free / 2 ** 20)} MB, more than the browser gives`);
            }
        }
        return at;
    }
    function put(values) {
        const at = take(values.byteLength);
        new Uint8Array(memory.buffer).set(new Uint8Array(values.buffer, values.byteOffset, values.byteLength), at);
        return at;
    }
    function text(at) {
        const all = new Uint8Array(memory.buffer);
        return new TextDecoder().decode(all.slice(at, all.indexOf(0, at)));
    }
    function check(code, detail) {
        if (code !== 0) throw new Error(text(core.seamwright_message(code)) + (detail ? ` (at ${detail})` : ''));
    }

    // mesh: { positions, corners, starts }; asked: some of { distortion, seed, size, padding, rays, charts, packing, effort }.
    function unwrap(mesh, asked) {
        const { positions, corners, starts } = mesh;
        const counts = { vertices: positions.length / 3, corners: corners.length, polygons: starts.length - 1 };
        free = core.__heap_base.value;
        const uv = take(16 * counts.corners), chart = take(4 * counts.polygons), exposure = take(4 * counts.vertices);
        const atlas = put(Uint32Array.of(uv, chart, exposure));
        const at = [put(positions), put(corners), put(starts)];
        const surface = put(
            Uint32Array.of(at[0], counts.vertices, at[1], counts.corners, at[2], counts.polygons, 0, 0),
        );
        const options = take(40), report = take(40), need = take(4);
        check(core.seamwright_defaults(options));
        let view = new DataView(memory.buffer);
        if ('distortion' in asked) view.setFloat64(options, asked.distortion, true);
        if ('seed' in asked) view.setBigUint64(options + 8, BigInt(asked.seed), true);
        ['size', 'padding', 'rays', 'charts', 'packing', 'effort'].forEach((name, i) => {
            if (name in asked) view.setUint32(options + 16 + 4 * i, asked[name], true);
        });
        check(core.seamwright_unwrap_scratch(need, surface, options));
        let bytes = view.getUint32(need, true), code, detail;
        const below = free;
        do {
            free = below;
            const scratch = take(bytes);
            code = core.seamwright_unwrap(atlas, report, surface, options, 0, scratch, bytes);
            view = new DataView(memory.buffer);
            detail = bytes = view.getUint32(report + 36, true);
        } while (code === SCRATCH && bytes);
        check(code, detail);
        return {
            uv: new Float64Array(memory.buffer.slice(uv, uv + 16 * counts.corners)),
            chart: new Uint32Array(memory.buffer.slice(chart, chart + 4 * counts.polygons)),
            exposure: new Float32Array(memory.buffer.slice(exposure, exposure + 4 * counts.vertices)),
            distortion: view.getFloat64(report, true),
            utilisation: view.getFloat64(report + 8, true),
            charts: view.getUint32(report + 16, true),
        };
    }

    return { version: text(core.seamwright_version()), unwrap };
}

if (typeof module !== 'undefined') module.exports = seamwright;
