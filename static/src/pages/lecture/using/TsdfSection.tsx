import { LabLink } from "../LabLink";
import { LaterFigure } from "../LaterFigure";
import { Section, type SectionHead } from "../Section";

export function TsdfSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<LaterFigure id="tsdf" />}
      sources={[["curless-levoy", "section 3"], ["newcombe", "section 3.3"], "octomap"]}
      after={
        <>
          <p>
            A reading z gives a voxel centred at c the distance d = z − c, and the voxel keeps the mean: D ← (W D + d) /
            (W + 1), W ← W + 1. Noise averages out, and interpolation between two voxels gives the surface{" "}
            <b>more finely than a voxel</b>. An occupancy map gives whole cells, and a reading that is too long leaves
            an occupied cell behind the wall. The gradient of D is the normal of the surface.
          </p>
          <p>
            Behind the <b>truncation</b> nothing is updated; a wall thinner than it gets readings of both sides into the
            same voxels. W stops at a <b>maximum weight</b>, so that the surface can follow a wall that moves.
          </p>
          <div class="actions no-print">
            <LabLink world="levels" map3d={{ kind: "tsdf", sensor: "depth_camera" }}>
              Open in the lab, in 3D
            </LabLink>
          </div>
        </>
      }
    >
      <p>
        An occupancy map says whether something is in a cell. A <b>truncated signed distance function (TSDF)</b> says
        how far away the surface is: positive in front of it, negative behind, 0 on it. The figure shows one beam and
        what both store of it. <span class="no-print">Drag the wall through a cell.</span>
      </p>
    </Section>
  );
}
