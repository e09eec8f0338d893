import { LabLink } from "./LabLink";
import { LaterFigure } from "./LaterFigure";
import { Section, type SectionHead } from "./Section";
import { SectionLink } from "./SectionLink";

export function TsdfSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<LaterFigure id="tsdf" />}
      sources={[
        ["curless-levoy", "section 3"],
        ["newcombe", "section 3.3"],
        ["octomap", "for the log-odds"],
      ]}
      after={
        <>
          <p>
            A reading z gives a voxel with its centre at c the distance d = z − c, and the voxel keeps the mean: D ← (W
            D + d) / (W + 1), W ← W + 1. The noise of the readings averages out, and linear interpolation between two
            voxels gives the position of the surface <b>more finely than a voxel</b>. An occupancy map gives whole
            cells, however many readings there are, and one reading that is too long leaves an occupied cell behind the
            wall that no other beam reaches. In three dimensions the gradient of D is the normal of the surface.
          </p>
          <p>
            Behind the <b>truncation</b> nothing is updated: a voxel there may belong to the other side of the wall. A
            wall thinner than the truncation gets readings of both sides into the same voxels, and their means are
            wrong. In front of it, free space is not stored unless it is asked for, and then each voxel on the beam
            costs memory, as in an occupancy map. W stops at a <b>maximum weight</b>, so that the surface can follow a
            wall that moves: move the wall with a maximum weight of 64, then of 4.
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
        An occupancy map estimates for each cell whether something is in it. A{" "}
        <b>truncated signed distance function (TSDF)</b> stores how far away the surface is: positive in front of it,
        negative behind it, 0 on it. The figure shows one beam and what both maps store of it. Drag the wall through a
        cell, add noise as in <SectionLink to="window" />, and compare the two maps.
      </p>
    </Section>
  );
}
