import { LaterFigure, OnStage, Section, type SectionHead, SectionLink } from "../Section";

export function OctreeSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={
        <OnStage scene="octree" label="The floor as an octree, cut at a height">
          <LaterFigure id="octree" />
        </OnStage>
      }
      sources={["octomap"]}
      after={
        <>
          <p>
            Halving the side of the cells of a dense grid makes <b>eight</b> times as many, most of them in empty rooms.
            An <b>octree</b> stores eight cells of one state as a single node, and has no nodes where nothing was
            measured: it grows with the surfaces, about <b>four</b> times. Each access descends from the root, and nodes
            are larger than cells: here it needs less memory only with fine cells.
          </p>
          <p>
            A <b>point cloud</b> keeps each reading; it grows with every scan and does not say what is free.
          </p>
        </>
      }
    >
      <p>
        The low table of <SectionLink to="low-table" /> is missing in a map on the laser’s plane, and a door with a low
        lintel appears free to a tall robot. A map of <b>cells in three dimensions</b>, voxels, has both.{" "}
        <span class="no-print">Move the cut, then make the cells finer and compare the memory.</span>
      </p>
    </Section>
  );
}
