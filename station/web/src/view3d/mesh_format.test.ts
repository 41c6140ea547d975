import { describe, expect, it } from 'vitest';
import { boundsOf, inferred, measured, MeshDamaged, readMesh, unknown } from './mesh_format';

/** Bytes of docs/console_api.md §7 written out by hand: a tetrahedron of a body, and a lens that shares its vertices. */
function tetrahedron(): ArrayBuffer {
  const bytes = new ArrayBuffer(16 + 48 + 48 + 4 + 48 + 4 + 2 * 28);
  const view = new DataView(bytes);
  let at = 0;
  const u32 = (...values: number[]): void => values.forEach((value) => (view.setUint32(at, value, true), (at += 4)));
  const f32 = (...values: number[]): void => values.forEach((value) => (view.setFloat32(at, value, true), (at += 4)));
  u32(0x4d534e41, 1, 4, 4);
  f32(0, 0, 0, 100, 0, 0, 0, 100, 0, 0, 0, 1700);
  f32(0, 0, -1, 1, 0, 0, 0, 1, 0, 0, 0, 1);
  [measured, inferred, unknown, measured].forEach((value) => view.setUint8(at++, value));
  u32(0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2);
  u32(2);
  u32(0, 9, 0);
  f32(0.5, 0.5, 0.5, 1);
  u32(9, 3, 2);
  f32(0.25, 0.5, 1, 0.125);
  return bytes;
}

function changed(change: (view: DataView) => void): ArrayBuffer {
  const bytes = tetrahedron();
  change(new DataView(bytes));
  return bytes;
}

describe('readMesh', () => {
  it('reads every field where the contract puts it', () => {
    const mesh = readMesh(tetrahedron());
    expect([...mesh.positions.slice(9)]).toEqual([0, 0, 1700]);
    expect([...mesh.normals.slice(0, 3)]).toEqual([0, 0, -1]);
    expect([...mesh.knowledge]).toEqual([0, 1, 2, 0]);
    expect([...mesh.indices.slice(9)]).toEqual([0, 3, 2]);
    expect(mesh.parts).toEqual([
      { firstIndex: 0, count: 9, kind: 'body', colour: [0.5, 0.5, 0.5, 1] },
      { firstIndex: 9, count: 3, kind: 'lens', colour: [0.25, 0.5, 1, 0.125] },
    ]);
  });

  it('makes one body of a mesh without parts', () => {
    const mesh = readMesh(changed((view) => view.setUint32(164, 0, true)).slice(0, 168));
    expect(mesh.parts).toHaveLength(1);
    expect(mesh.parts[0]).toMatchObject({ firstIndex: 0, count: 12, kind: 'body' });
  });

  it('refuses every shorter piece of a mesh', () => {
    const whole = tetrahedron();
    for (let size = 0; size < whole.byteLength; ++size) expect(() => readMesh(whole.slice(0, size))).toThrow(MeshDamaged);
  });

  it('refuses bytes behind the end', () => {
    const longer = new Uint8Array(tetrahedron().byteLength + 1);
    longer.set(new Uint8Array(tetrahedron()));
    expect(() => readMesh(longer.buffer)).toThrow(MeshDamaged);
  });

  it.each([
    ['another magic', (view: DataView) => view.setUint32(0, 0x4d534e42, true)],
    ['another version', (view: DataView) => view.setUint32(4, 2, true)],
    ['more vertices than there are', (view: DataView) => view.setUint32(8, 5, true)],
    ['so many vertices that sizes would overflow', (view: DataView) => view.setUint32(8, 0xffffffff, true)],
    ['so many triangles that sizes would overflow', (view: DataView) => view.setUint32(12, 0xffffffff, true)],
    ['a vertex that is no number', (view: DataView) => view.setFloat32(16, NaN, true)],
    ['a vertex at infinity', (view: DataView) => view.setFloat32(20, Infinity, true)],
    ['a normal that is too long', (view: DataView) => view.setFloat32(64, 2, true)],
    ['unknown knowledge', (view: DataView) => view.setUint8(112, 3)],
    ['an index beyond the vertices', (view: DataView) => view.setUint32(116, 4, true)],
    ['more parts than there are', (view: DataView) => view.setUint32(164, 3, true)],
    ['a part that begins within a triangle', (view: DataView) => view.setUint32(168, 1, true)],
    ['a part beyond the indices', (view: DataView) => view.setUint32(172, 15, true)],
    ['a part of unknown kind', (view: DataView) => view.setUint32(176, 4, true)],
    ['a colour above 1', (view: DataView) => view.setFloat32(180, 1.5, true)],
    ['an opacity that is no number', (view: DataView) => view.setFloat32(192, NaN, true)],
  ])('refuses %s', (_, change) => {
    expect(() => readMesh(changed(change))).toThrow(MeshDamaged);
  });

  it('never reads beyond the bytes, whatever single byte is damaged', () => {
    const whole = new Uint8Array(tetrahedron());
    for (let at = 0; at < whole.length; ++at) {
      for (const value of [0x00, 0x7f, 0x80, 0xff]) {
        const bytes = whole.slice();
        bytes[at] = value;
        try {
          const mesh = readMesh(bytes.buffer);
          expect(Math.max(...mesh.indices)).toBeLessThan(mesh.knowledge.length);
        } catch (error) {
          expect(error).toBeInstanceOf(MeshDamaged);
        }
      }
    }
  });
});

describe('boundsOf', () => {
  it('is the box about all vertices', () => {
    expect(boundsOf(readMesh(tetrahedron()))).toEqual({ low: [0, 0, 0], high: [100, 100, 1700] });
  });
});
