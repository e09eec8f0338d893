/** P of a patch entry by entry, and what follows from it. */

import type { ComponentChildren } from "preact";
import { written } from "../../ui/numbers";
import {
  type Limits,
  type Moments,
  type Place,
  type Plane,
  ratiosOf,
  scoreOf,
  slopeWithoutRoot,
  stepOf,
} from "./model";

const DEGREE = 180 / Math.PI;
const NAMES = ["1", "x", "y", "h"];

interface NumberTableProps {
  readonly label: string;
  readonly corner: string;
  readonly columns: readonly string[];
  /** Its rows. */
  readonly children: ComponentChildren;
}

function NumberTable({ label, corner, columns, children }: NumberTableProps) {
  return (
    <div class="table-room">
      <table class="patch-matrix" aria-label={label}>
        <thead>
          <tr>
            <th scope="col">{corner}</th>
            {columns.map((name) => (
              <th scope="col" key={name}>
                {name}
              </th>
            ))}
          </tr>
        </thead>
        <tbody>{children}</tbody>
      </table>
    </div>
  );
}

interface MatrixProps {
  readonly moments: Moments;
  /** P before the point that moved last was moved. */
  readonly before: Moments;
}

/** P as a table; entries that the newest move has changed are marked. */
export function Matrix({ moments, before }: MatrixProps) {
  return (
    <NumberTable label="P, the sum of v vᵀ" corner="P" columns={NAMES}>
      {NAMES.map((name, row) => (
        <tr key={name}>
          <th scope="row">{name}</th>
          {NAMES.map((other, col) => {
            const now = moments[4 * row + col] as number;
            const isChanged = Math.abs(now - (before[4 * row + col] as number)) > 5e-3;
            return (
              <td key={other} class={isChanged ? "changed" : ""}>
                {row + col === 0 ? written(now, 0) : written(now, 2)}
              </td>
            );
          })}
        </tr>
      ))}
    </NumberTable>
  );
}

interface ResultProps {
  readonly plane: Plane | null;
  readonly limits: Limits;
  /** Places in the middle of its edges, on the planes of its neighbours. */
  readonly edges: readonly Place[];
}

/** A further term of a sum, with its sign apart: what is written as 0.00 is not negative. */
const added = (factor: number): string => `${factor <= -0.005 ? "−" : "+"} ${written(Math.abs(factor), 2)}`;

/** The plane, its residual, its slope, and the class that follows. */
export function Result({ plane, limits, edges }: ResultProps) {
  if (!plane) return <p>These points give no plane.</p>;
  const { a, b, c, n, meanHeight, residual, roughness, slope } = plane;
  return (
    <div class="patch-result">
      <dl>
        <div>
          <dt>Plane</dt>
          <dd>
            h = {written(a, 2)} {added(b)} x {added(c)} y
          </dd>
        </div>
        <div>
          <dt>Points n = P₁₁</dt>
          <dd>{n}</dd>
        </div>
        <div>
          <dt>Mean height P₁₄ / n</dt>
          <dd>{written(meanHeight, 2)} m</dd>
        </div>
        <div>
          <dt>Residual, a sum of squares</dt>
          <dd>{written(residual, 3)} m²</dd>
        </div>
        <div>
          <dt>Roughness √(residual / n)</dt>
          <dd>{written(roughness, 3)} m</dd>
        </div>
        <div>
          <dt>Slope cos⁻¹(1 / √(1 + b² + c²))</dt>
          <dd>{written(slope * DEGREE, 1)}°</dd>
        </div>
        {limits.step !== undefined && (
          <div>
            <dt>Step to the neighbours’ planes</dt>
            <dd>{edges.length ? `${written(stepOf(plane, edges), 3)} m` : "no neighbour has a plane"}</dd>
          </div>
        )}
        <div class="patch-slip">
          <dt>Without the root</dt>
          <dd>{written(slopeWithoutRoot(plane) * DEGREE, 1)}°, not the angle of the plane</dd>
        </div>
      </dl>
      <Class plane={plane} limits={limits} edges={edges} />
    </div>
  );
}

function Class({ plane, limits, edges }: { readonly plane: Plane } & Omit<ResultProps, "plane">) {
  const score = scoreOf(plane, limits, edges);
  const isSafe = score <= 1;
  const terms = ratiosOf(plane, limits, edges).map(({ name, value }) => `${written(value, 2)} for the ${name}`);
  return (
    <p class={`patch-class ${isSafe ? "safe" : "unsafe"}`} role="status">
      <b>{isSafe ? "Safe" : "Unsafe"}</b>:{" "}
      {limits.isThresholds
        ? `the greatest of ${terms.join(", ")} is ${written(score, 2)}`
        : `${terms.join(" + ")} = ${written(score, 2)}`}
      , {isSafe ? "at most" : "above"} 1
    </p>
  );
}

const SUMS = ["n", "Σx", "Σy", "Σh"];

/** The first row of P of the four children of a patch in the quadtree, and their sum, its own. */
export function Children({ moments }: { readonly moments: readonly Moments[] }) {
  const rows = moments.map((child) => child.slice(0, 4));
  const sum = SUMS.map((_, k) => rows.reduce((total, row) => total + (row[k] as number), 0));
  return (
    <NumberTable label="The four children of this patch, and their sum" corner="Child" columns={SUMS}>
      {[...rows, sum].map((row, at) => (
        <tr key={at}>
          <th scope="row">{at < rows.length ? at + 1 : "Sum"}</th>
          {row.map((value, k) => (
            <td key={k}>{written(value, k === 0 ? 0 : 2)}</td>
          ))}
        </tr>
      ))}
    </NumberTable>
  );
}
