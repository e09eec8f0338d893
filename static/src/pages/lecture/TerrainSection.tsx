import { Patch } from "../../lessons/terrain/Patch";
import { Section, type SectionHead } from "./Section";

export function TerrainSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<Patch />}
      sources={[["ransac", "for the plane of the most points"]]}
      after={
        <>
          <p>
            P = Σ p pᵀ with p = [1 x y z]ᵀ holds all that the plane needs: AᵀA is its upper left block of 3 × 3, Aᵀb
            stands in its last column, bᵀb in the corner. A new point adds one term, and the points themselves can be
            forgotten. Patches add up as well: a patch of twice the size is the sum of four, which makes a quadtree, and
            a table of running sums gives a window of any size around every patch.
          </p>
          <p>
            Two slips are common. The slope is cos⁻¹(1 / √(1 + b² + c²)): without the root it is the angle of no plane.
            And zᵀz − … is a <b>sum</b> of squares, which grows with every point: “twice” doubles it on the same ground.
            Roughness divides by n. The class is a weighted sum of slope and roughness, and of the step to the next
            patch, each divided by what is just safe, against a threshold. A stone bends the plane of least squares;{" "}
            <b>RANSAC</b> finds the plane of the most points and leaves the stone out.
          </p>
        </>
      }
    >
      <p>
        Outdoors the question is not whether a cell is occupied, but whether its ground is safe. The points of each{" "}
        <b>patch</b> of a grid are described by a plane z = a + b x + c y, found by least squares, (AᵀA)⁻¹Aᵀb: its
        slope, how rough the points lie around it, how high it is, and how many points there are. Drag the points up and
        down, and see which entries of P change, and when the patch becomes unsafe.
      </p>
    </Section>
  );
}
