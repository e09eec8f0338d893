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
            D + d) / (W + 1), W ← W + 1. The noise of the readings averages out, and a line between two voxels has its
            zero at their mean: the surface is found more <b>finely than a voxel</b>. Occupancy answers with whole
            cells, however many readings there are, and one reading that is too long leaves an occupied cell behind the
            wall that no other beam reaches. In three dimensions the gradient of D is the normal of the surface.
          </p>
          <p>
            Behind the <b>truncation</b> nothing is updated: a voxel there may belong to the other side of the wall. A
            wall thinner than the truncation gets readings of both sides into the same voxels, and their means are
            wrong. Before it, free space is not stored unless somebody asks for it, and then each voxel on the beam
            costs memory, as in a map of occupancy. W stops at a <b>greatest weight</b>, so that a surface that moves is
            followed: move the wall with a greatest weight of 64, then of 4.
          </p>
        </>
      }
    >
      <p>
        Occupancy asks of each cell whether something is in it. A <b>truncated signed distance function (TSDF)</b> asks
        how far the surface is: positive before it, negative behind it, 0 on it. Here is one beam, and what both maps
        keep of it. Drag the wall through a cell, add noise as in <SectionLink to="window" />, and compare the two
        answers.
      </p>
    </Section>
  );
}
