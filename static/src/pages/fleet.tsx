import "../style/index.css";
import "./logs/library/library.css";
import "./fleet/fleet.css";
import { showOther } from "../tools/classroom/pages";
import { Fleet } from "./fleet/Fleet";
import { renderPage } from "./renderPage";

showOther();
renderPage(<Fleet />, { current: "logs" });
