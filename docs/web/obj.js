// OBJ files in the browser: positions and polygons out of the bytes, and the same bytes back with other UVs.
// The rules are those of cli/src/formats/obj: `vt` lines are replaced, face corners become v/vt or v/vt/vn, all else stays byte for
// byte. Text is handled as one character a byte, so that names may be in any encoding.
'use strict';

const Obj = (() => {
    const NUMBER = /^[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?$/;
    const CORNER = /^([+-]?\d+)(?:\/([+-]?\d*))?(?:\/([+-]?\d*))?$/;
    const WORD = /(?:[^ \t\r\n\f\v\\]|\\(?![ \t\r\n\f]|$))+/g; // a backslash before white space joins lines

    function textOf(bytes) {
        let text = '';
        for (let i = 0; i < bytes.length; i += 8192) text += String.fromCharCode(...bytes.subarray(i, i + 8192));
        return text;
    }

    // Statements: a line, or several joined by a backslash at their end, with the line end behind them.
    function statements(text) {
        const out = [];
        const lineEnd = /\r\n|\n|\r|$/g;
        let start = 0, line = 1, first = 1;
        for (let at = 0; at < text.length; line++) {
            lineEnd.lastIndex = at;
            const { index: end, 0: newline } = lineEnd.exec(text);
            const next = end + newline.length;
            const joins = /\\[ \t\f]*$/.test(text.slice(at, end)) && !text.slice(at, end).includes('#');
            at = next;
            if (joins && next < text.length) continue;
            while (text.startsWith('\xEF\xBB\xBF', start)) start += 3;
            if (start < next) out.push({ line: first, start, end: Math.max(start, end), next });
            start = next;
            first = line + 1;
        }
        return out;
    }

    // Words with their places; one that begins with # ends the statement.
    function words(text) {
        const out = [];
        for (const { 0: word, index } of text.matchAll(WORD)) {
            if (word[0] === '#') break;
            out.push({ word, start: index, end: index + word.length });
        }
        return out;
    }

    function read(bytes) {
        const text = textOf(bytes);
        const positions = [], corners = [], starts = [0], normals = [], edits = [], lines = [];
        let textures = 0, normalCount = 0;
        const fail = (line, what) => { throw new Error(`line ${line}: ${what}`); };
        const reference = (field, count) => {
            if (field === undefined || field === '') return 0;
            const i = Number(field);
            return i > 0 ? i : i === 0 || -i > count ? Infinity : count + i + 1;
        };
        for (const { line, start, end, next } of statements(text)) {
            const [keyword, ...rest] = words(text.slice(start, end));
            if (!keyword) continue;
            if (keyword.word === 'v') {
                if (rest.length < 3) fail(line, 'a vertex needs three coordinates');
                for (const { word } of rest.slice(0, 3)) {
                    const value = Number(word);
                    if (!NUMBER.test(word) || !Number.isFinite(value)) fail(line, `${word} is not a finite number`);
                    positions.push(value);
                }
            } else if (keyword.word === 'vn') {
                normalCount++;
            } else if (keyword.word === 'vt') {
                textures++;
                edits.push({ start, end: next, kind: 'texture' });
            } else if ((keyword.word === 'f' || keyword.word === 'fo') && rest.length >= 3) {
                for (const { word } of rest) {
                    const fields = CORNER.exec(word);
                    if (!fields) fail(line, `${word} is not a corner of a face`);
                    const i = Number(fields[1]), count = positions.length / 3;
                    if (i === 0 || -i > count) fail(line, `there is no vertex ${i}`);
                    corners.push(i > 0 ? i - 1 : count + i);
                    normals.push(reference(fields[3], normalCount));
                    lines.push(line);
                }
                starts.push(corners.length);
                edits.push({ start, end, kind: 'face' });
            } else if (['f', 'fo', 'l', 'surf'].includes(keyword.word)) {
                const refers = ({ word }) => (CORNER.exec(word) || [])[2];
                if (rest.some(refers)) edits.push({ start, end, kind: 'detach' });
            }
        }
        const beyond = corners.findIndex((v) => v >= positions.length / 3);
        if (beyond >= 0) fail(lines[beyond], `there is no vertex ${corners[beyond] + 1}`);
        return {
            text,
            edits,
            normals: normals.map((n) => (n > normalCount ? 0 : n)),
            positions: Float64Array.from(positions),
            corners: Uint32Array.from(corners),
            starts: Uint32Array.from(starts),
        };
    }

    // The shortest decimal that reads back the same, without an exponent; of two that are equally near the larger one, as
    // the command writes it, where the browser takes the even one. `x` is a UV: k / 2^24 in [0, 1], 24 digits at the most.
    function decimal(x) {
        const [digits, exponent] = String(x).split('e');
        const [whole, part = ''] = digits.split('.');
        const text = exponent ? `0.${'0'.repeat(-exponent - 1)}${whole}${part}` : digits;
        const isTie = x.toFixed(24).replace(/0+$/, '') === `${text}5`;
        return isTie ? text.slice(0, -1) + (Number(text.at(-1)) + 1) : text; // even, so never a 9
    }

    function write(obj, uv) {
        const { text, edits, normals, corners, starts } = obj;
        const newline = (/\r\n|\n|\r/.exec(text) || ['\n'])[0];
        const known = new Map(), texture = [];
        let table = '';
        for (let c = 0; c < corners.length; c++) {
            const line = `vt ${decimal(uv[2 * c] + 0)} ${decimal(uv[2 * c + 1] + 0)}`;
            if (!known.has(line)) {
                known.set(line, known.size + 1);
                table += line + newline;
            }
            texture.push(known.get(line));
        }
        const gap = (between) => {
            const end = Math.max(between.lastIndexOf('\n'), between.lastIndexOf('\r'));
            return end < 0 ? between : ' ' + between.slice(end + 1).trimStart();
        };
        const out = [];
        let written = 0, polygon = 0, placed = false;
        for (const { start, end, kind } of edits) {
            out.push(text.slice(written, start));
            written = end;
            if (!placed && kind !== 'detach') {
                out.push(table);
                placed = true;
            }
            if (kind === 'texture') continue;
            const statement = text.slice(start, end);
            const [keyword, ...rest] = words(statement);
            let at = 0, c = starts[polygon];
            if (kind === 'face') {
                out.push(gap(statement.slice(0, keyword.start)), keyword.word);
                at = keyword.end;
            }
            for (const { word, start: from, end: to } of rest) {
                const fields = CORNER.exec(word);
                if (kind === 'face') {
                    const normal = normals[c] ? `/${normals[c]}` : '';
                    out.push(gap(statement.slice(at, from)), `${corners[c] + 1}/${texture[c]}${normal}`);
                    at = to;
                    c++;
                } else if (fields && fields[2]) {
                    out.push(statement.slice(at, from), fields[1], fields[3] ? `//${fields[3]}` : '');
                    at = to;
                }
            }
            out.push(kind === 'face' ? gap(statement.slice(at)) : statement.slice(at));
            polygon += kind === 'face';
        }
        out.push(text.slice(written));
        return Uint8Array.from(out.join(''), (character) => character.charCodeAt(0));
    }

    return { read, write };
})();

if (typeof module !== 'undefined') module.exports = Obj;
