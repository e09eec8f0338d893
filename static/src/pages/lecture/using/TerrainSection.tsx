import { Patch } from "../../../lessons/terrain/Patch";
import { Section, type SectionHead } from "../Section";

export function TerrainSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<Patch />}
      sources={["ransac"]}
      after={
        <>
          <p>
            P = Σ v vᵀ with v = [1 x y h]ᵀ holds all sums that the fit needs: AᵀA is its upper left 3 × 3 block, Aᵀh is
            in its last column, hᵀh in the corner. A new point adds one term and need not be kept. Patches add up: one
            of twice the size is the sum of four, which makes a quadtree.
          </p>
          <p>
            Two slips are common: the root in the slope is forgotten, and the residual hᵀh − …, a <b>sum</b> of squares,
            is not divided by n, so that the roughness grows with every point. The class compares a weighted sum of
            slope, roughness and the step to the next patch, each divided by its safe limit, with a threshold. A stone
            tilts the least-squares plane; <b>RANSAC</b> finds the plane that most points agree with.
          </p>
        </>
      }
    >
      <p>
        Can a robot drive safely on this ground? The points of each <b>patch</b> of a grid get a plane h = a + b x + c y
        by least squares, (AᵀA)⁻¹Aᵀh, where A has a row [1 x y] and h the height of each point: its slope, its height,
        the roughness of the points around it, and their number.{" "}
        <span class="no-print">
          Drag the points, and see which entries of the matrix P change and when the patch becomes unsafe.
        </span>
      </p>
    </Section>
  );
}
