// The shapes that go over the API, under the names the app uses. They are generated from the server's description
// (`schema.d.ts`), where each field is explained; units and datum stand in the names, what is not known is null.
import type { components, operations, paths } from './schema';

type Schemas = components['schemas'];

// Telemetry
export type Attitude = Schemas['Attitude'];
export type Position = Schemas['Position'];
export type Battery = Schemas['Battery'];
export type Pressure = Schemas['Pressure'];
export type Wind = Schemas['Wind'];

/** What changed of the groups; null for one that the vehicle no longer has, as after a reboot. */
export type TelemetryChanges = Schemas['TelemetryGroups'];
export type GroupName = keyof TelemetryChanges;
/** All groups by name; a group is absent until the vehicle has sent it. */
export type TelemetryGroups = { [Name in GroupName]?: NonNullable<TelemetryChanges[Name]> };

// Vehicles and links
export type MissionProgress = Schemas['MissionProgress'];
export type Assessment = Schemas['Assessment'];
export type Trip = Schemas['Trip'];
export type Way = Schemas['Way'];
export type Rehearsal = Schemas['Rehearsal'];
export type BatteryLeft = Schemas['BatteryLeft'];
export type RehearsedFlight = Schemas['RehearsedFlight'];
export type Airframe = Schemas['Airframe'];
export type PlaneProfile = Schemas['PlaneProfile'];
export type BatterySettings = Schemas['BatterySettings'];
export type VehicleProfile = Schemas['VehicleProfile'];
export type LearnedPlane = Schemas['LearnedPlane'];
export type SpreadRequest = Schemas['SpreadRequest'];
export type Spread = Schemas['Spread'];
export type Trigger = Schemas['Trigger'];
export type Beginning = Schemas['Beginning'];
export type Outlook = Schemas['Outlook'];
export type FrameChange = Schemas['FrameChange'];
export type CountedItems = Schemas['CountedItems'];
export type UnknownLevel = Schemas['UnknownLevel'];
export type WhatIf = Schemas['WhatIf'];
export type WhatIfRequest = Schemas['WhatIfRequest'];
export type WhatIfs = Schemas['WhatIfs'];
export type PlanWind = Schemas['PlanWind'];
export type PlanKind = Schemas['PlanKind'];
export type PlanChange = Schemas['PlanChange'];
export type PlanComparison = Schemas['PlanComparison'];
export type PlanOnBoard = Schemas['PlanOnBoard'];
export type PlanState = Schemas['PlanState'];
export type LinkInfo = Schemas['LinkInfo'];
export type NewLink = Schemas['NewLink'];
export type SerialPort = Schemas['SerialPort'];
export type FlightParameters = Schemas['FlightParameters'];
export type VehicleSummary = Schemas['VehicleSummary'];
export type VehicleState = Schemas['VehicleState'];
export type StatusText = Schemas['Text'];
export type Parameter = Schemas['Param'];
export type FileParameter = Schemas['FileParam'];
export type Separation = Schemas['Separation'];
export type SeparationRequest = Schemas['SeparationRequest'];
export type SigningInfo = Schemas['SigningInfo'];
export type SigningAct = Schemas['SigningAct'];
export type ChangeSigning = Schemas['ChangeSigning'];

// Plans
export type Home = Schemas['Home'];
export type PlanItem = Schemas['PlanItem'];
export type FenceZone = Schemas['FenceZone'];
export type Fence = Schemas['Fence'];
export type RallyPoint = Schemas['RallyPoint'];
export type Plan = Schemas['Plan'];
export type PlanFileNote = Schemas['PlanFileNote'];
export type PlanFileFormat = operations['format_plan']['parameters']['query']['as'];
export type PlanFinding = Schemas['Finding'];
export type FindingFix = Schemas['FindingFix'];
export type RehearsalRequest = Schemas['RehearsalRequest'];
export type LandingRequest = Schemas['LandingRequest'];
export type LandingMove = Schemas['LandingMove'];
export type LandingAlternative = Schemas['LandingAlternative'];
export type Landing = Schemas['Landing'];
export type Camera = Schemas['Camera'];
export type NamedCamera = Schemas['NamedCamera'];
export type SurveyRequest = Schemas['SurveyRequest'];
export type Survey = Schemas['Survey'];
export type ComplexPart = Schemas['ComplexPart'];

// Sessions, operations, errors
export type Info = Schemas['Info'];
export type Session = Schemas['SessionInfo'];
export type NewSession = Schemas['NewSession'];
export type DeclinedRequest = Schemas['DeclinedRequest'];
export type FleetNetwork = Schemas['FleetNetwork'];
export type VehicleControl = Schemas['VehicleControl'];
export type Cause = Schemas['Cause'];
export type RefusalCode = Schemas['RefusalCode'];
/** A problem of the server has a cause; one made here has none. */
export type Problem = Omit<Schemas['Problem'], 'cause'> & { cause?: Cause };
export type Operation<Result = Schemas['OperationResult']> = Omit<Schemas['Operation'], 'result' | 'error'> & {
  result?: Result;
  error?: Problem;
};

type Body<Path> = Path extends { post: { requestBody?: { content: { 'application/json': infer Given } } } }
  ? NonNullable<Given>
  : Record<string, never>;
type OfVehicles = {
  [Path in keyof paths as Path extends `/api/v1/vehicles/{id}/${infer Name}` ? Name : never]: Body<paths[Path]>;
};
/** The commands of a vehicle: request bodies by path. */
export type VehicleCommands = Pick<
  OfVehicles,
  | 'arm'
  | 'disarm'
  | 'mode'
  | 'takeoff'
  | 'goto'
  | 'speed'
  | 'altitude'
  | 'loiter'
  | 'return-to-launch'
  | 'land'
  | 'abort-landing'
  | 'prepare-flight'
  | 'mission/start'
  | 'mission/pause'
  | 'mission/resume'
  | 'mission/current'
  | 'home'
  | 'reboot'
>;
export type CommandName = keyof VehicleCommands;

// What the server keeps
export type StorageProblem = Schemas['StorageProblem'];
/** Its plan is unchecked input: callers validate it. */
export type PlanDraft = Omit<Schemas['PlanDraft'], 'plan'> & { plan: unknown };
export type PlanDrafts = Omit<Schemas['PlanDrafts'], 'current' | 'others'> & {
  current: PlanDraft | null;
  others: PlanDraft[];
};
export type NewPlanDraft = Omit<Schemas['NewPlanDraft'], 'plan'> & { plan: unknown };

// WebSocket
export type ServerMessage = Schemas['ServerMessage'];
export type ClientMessage = Schemas['ClientMessage'];
