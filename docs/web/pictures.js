// What the page draws on its canvases: the atlas, and the mesh with its seams from any side.
'use strict';

const Pictures = (() => {
    const NONE = 0xffffffff;

    // Neighbouring charts differ: the golden angle round the circle of hues.
    function colour(chart, light) {
        return chart === NONE ? `hsl(0 0% ${light}%)` : `hsl(${(chart * 137.508) % 360} 60% ${light}%)`;
    }

    // For each corner, whether the side from it to the next corner of its polygon is a seam: two polygons meet there, by
    // place, and their UVs do not.
    function seams(mesh, uv) {
        const { positions, corners, starts } = mesh;
        const places = new Map();
        const place = Uint32Array.from({ length: positions.length / 3 }, (_, v) => {
            const key = positions.subarray(3 * v, 3 * v + 3).join();
            if (!places.has(key)) places.set(key, places.size);
            return places.get(key);
        });
        const sides = new Map(), next = new Uint32Array(corners.length);
        for (let p = 0; p + 1 < starts.length; p++) {
            for (let c = starts[p]; c < starts[p + 1]; c++) {
                next[c] = c + 1 < starts[p + 1] ? c + 1 : starts[p];
                const a = place[corners[c]], b = place[corners[next[c]]];
                const key = Math.min(a, b) * 2 ** 26 + Math.max(a, b);
                if (!sides.has(key)) sides.set(key, []);
                sides.get(key).push(a < b ? [c, next[c], c] : [next[c], c, c]);
            }
        }
        const same = (c, d) => uv[2 * c] === uv[2 * d] && uv[2 * c + 1] === uv[2 * d + 1];
        const out = new Uint8Array(corners.length);
        for (const list of sides.values()) {
            const [low, high] = list[0];
            const joined = list.every(([a, b]) => same(a, low) && same(b, high));
            if (!joined) list.forEach(([, , c]) => { out[c] = 1; });
        }
        return { isSeam: out, next };
    }

    function path(canvas, points) {
        canvas.beginPath();
        points.forEach(([x, y], i) => (i ? canvas.lineTo(x, y) : canvas.moveTo(x, y)));
        canvas.closePath();
    }

    function atlas(element, mesh, result, { isSeam, next }) {
        const canvas = element.getContext('2d'), side = element.width;
        const at = (c) => [result.uv[2 * c] * side, (1 - result.uv[2 * c + 1]) * side];
        canvas.clearRect(0, 0, side, side);
        canvas.lineWidth = 1;
        for (let p = 0; p + 1 < mesh.starts.length; p++) {
            const points = [];
            for (let c = mesh.starts[p]; c < mesh.starts[p + 1]; c++) points.push(at(c));
            canvas.fillStyle = canvas.strokeStyle = colour(result.chart[p], 72);
            path(canvas, points);
            canvas.fill();
            canvas.stroke();
        }
        canvas.strokeStyle = '#c00';
        canvas.beginPath();
        isSeam.forEach((seam, c) => {
            if (!seam) return;
            canvas.moveTo(...at(c));
            canvas.lineTo(...at(next[c]));
        });
        canvas.stroke();
    }

    // Polygons from the farthest to the nearest, each followed by its seams. `turn` and `tilt` in radians.
    function surface(element, mesh, result, { isSeam, next }, turn, tilt) {
        const { positions, corners, starts } = mesh;
        const canvas = element.getContext('2d'), side = element.width;
        const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
        for (const v of corners) {
            for (let k = 0; k < 3; k++) {
                low[k] = Math.min(low[k], positions[3 * v + k]);
                high[k] = Math.max(high[k], positions[3 * v + k]);
            }
        }
        const middle = low.map((l, k) => (l + high[k]) / 2);
        const away = (v) => Math.hypot(...middle.map((m, k) => positions[3 * v + k] - m));
        const radius = corners.reduce((most, v) => Math.max(most, away(v)), 0) || 1;
        const [ct, st, ci, si] = [Math.cos(turn), Math.sin(turn), Math.cos(tilt), Math.sin(tilt)];
        const seen = new Float64Array(positions.length); // x, y on the canvas; depth towards the eye
        for (let v = 0; v < positions.length / 3; v++) {
            const [x, y, z] = [0, 1, 2].map((k) => (positions[3 * v + k] - middle[k]) / radius);
            const [right, front] = [ct * x + st * z, ct * z - st * x];
            const [up, near] = [ci * y - si * front, si * y + ci * front];
            seen.set([side / 2 * (1 + 0.95 * right), side / 2 * (1 - 0.95 * up), near], 3 * v);
        }
        const at = (c) => [seen[3 * corners[c]], seen[3 * corners[c] + 1]];
        const depth = Float64Array.from({ length: starts.length - 1 }, (_, p) => {
            let sum = 0;
            for (let c = starts[p]; c < starts[p + 1]; c++) sum += seen[3 * corners[c] + 2];
            return sum / (starts[p + 1] - starts[p]);
        });
        const order = Uint32Array.from(depth.keys()).sort((a, b) => depth[a] - depth[b]);
        canvas.clearRect(0, 0, side, side);
        canvas.lineCap = 'round';
        for (const p of order) {
            const points = [];
            let area = 0, sides = 0;
            for (let c = starts[p]; c < starts[p + 1]; c++) {
                const [[x, y], [u, v]] = [at(c), at(next[c])];
                area += (u * y - x * v) / 2;
                sides += Math.hypot(u - x, v - y);
                points.push([x, y]);
            }
            // Compactness on the canvas stands in for the light: what is seen edge on is dark.
            const light = 45 + 35 * Math.min(1, 20 * Math.abs(area) / (sides * sides || 1));
            canvas.fillStyle = canvas.strokeStyle = colour(result.chart[p], light);
            canvas.lineWidth = 0.7;
            path(canvas, points);
            canvas.fill();
            canvas.stroke();
            canvas.strokeStyle = '#c00';
            canvas.lineWidth = 2.5;
            canvas.beginPath();
            for (let c = starts[p]; c < starts[p + 1]; c++) {
                if (!isSeam[c]) continue;
                canvas.moveTo(...at(c));
                canvas.lineTo(...at(next[c]));
            }
            canvas.stroke();
        }
    }

    return { seams, atlas, surface };
})();
