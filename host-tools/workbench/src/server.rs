//! The server: sockets, routes and handlers.

use super::access::{AccessToken, Reach};
use super::before::Before;
use super::connections::{self, ActiveRequests, Bounded, MOST};
use super::files::Files;
use super::folder::Folder;
use super::jobs::queue::Jobs;
use super::jobs::simulation::Simulator;
use super::live::Live;
use super::problem::Problem;
use super::state::{Shared, Workbench};
use super::{assets, change, guard, jobs, lists, live_requests, models, recordings};
use anyhow::{Context, Result, anyhow};
use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::middleware::{from_fn, from_fn_with_state};
use axum::routing::{get, post};
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr};
use std::path::Path;
use std::sync::Arc;
use tokio::net::TcpListener;
use tokio::runtime::Runtime;
use tokio::sync::Semaphore;

/// Largest body of a request, bytes.
const LARGEST_BODY: usize = 64 << 10;

/// A workbench with open ports that does not answer yet.
pub struct Server {
    runtime: Runtime,
    listeners: Vec<TcpListener>,
    bench: Shared,
}

impl Server {
    /// Opens a folder and a port; port 0 takes a free one. `simulator` carries out the runs that pages request.
    ///
    /// # Errors
    ///
    /// The folder cannot be opened, or the port is taken.
    pub fn new(folder: &Path, port: u16, reach: Reach, simulator: Box<Simulator>) -> Result<Self> {
        let folder = Folder::new(folder)?;
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()?;
        let (listeners, port) = runtime.block_on(listen(&reach, port))?;
        let bench = Arc::new(Workbench {
            folder,
            files: Files::default(),
            jobs: Jobs::start(),
            before: Before::default(),
            live: Live::default(),
            simulator,
            reach,
            token: token()?,
            port,
        });
        Ok(Self {
            runtime,
            listeners,
            bench,
        })
    }

    /// URL of the page.
    pub fn url(&self) -> String {
        let reach = &self.bench.reach;
        let query = reach.token().map_or(String::new(), AccessToken::query);
        let host = SocketAddr::new(reach.host(), self.bench.port);
        format!("http://{host}/{query}")
    }

    /// Answers until the program ends.
    ///
    /// # Errors
    ///
    /// The system takes the port away.
    pub fn serve(self) -> Result<()> {
        let places = Arc::new(Semaphore::new(MOST));
        let app = router(self.bench).into_make_service_with_connect_info::<ActiveRequests>();
        self.runtime.block_on(async {
            let mut serving = tokio::task::JoinSet::new();
            for listener in self.listeners {
                let bounded = Bounded {
                    listener,
                    places: places.clone(),
                };
                let serve = axum::serve(bounded, app.clone());
                serving.spawn(async { serve.await });
            }
            match serving.join_next().await {
                Some(ended) => Ok(ended??),
                None => Ok(()),
            }
        })
    }
}

/// Opens the address of `reach`; for this computer both loopback addresses (IPv4 alone where there is no IPv6).
async fn listen(reach: &Reach, port: u16) -> Result<(Vec<TcpListener>, u16)> {
    let address = match reach {
        Reach::ThisComputer => SocketAddr::from((Ipv4Addr::LOCALHOST, port)),
        Reach::Network(address, _) => SocketAddr::new(*address, port),
    };
    let first = TcpListener::bind(address).await.with_context(|| {
        format!(
            "cannot listen on {address}; is another workbench running? --port 0 takes a free port"
        )
    })?;
    let port = first.local_addr()?.port();
    let second = match reach {
        Reach::ThisComputer => TcpListener::bind((Ipv6Addr::LOCALHOST, port)).await.ok(),
        Reach::Network(..) => None,
    };
    Ok((std::iter::once(first).chain(second).collect(), port))
}

/// A token of 128 random bits.
fn token() -> Result<String> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes)
        .map_err(|error| anyhow!("the system gives no random numbers: {error}"))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

fn router(bench: Shared) -> Router {
    let api = Router::new()
        .route("/session", get(lists::session))
        .route("/recordings", get(recordings::list))
        .route("/recordings/{id}/channels", get(recordings::channels))
        .route("/recordings/{id}/series", get(recordings::series))
        .route("/scenarios", get(lists::scenarios))
        .route("/models", get(models::list))
        .route("/models/{id}", get(models::one))
        .route("/models/{id}/history", get(models::history))
        .route("/models/{id}/effects", post(change::add))
        .route("/models/{id}/undo", post(change::undo))
        .route("/models/{id}/effects/{effect}/remove", post(change::remove))
        .route("/compare", post(models::compare))
        .route("/prediction", get(models::prediction))
        .route("/check", post(jobs::selection::check))
        .route("/effects", get(lists::effects))
        .route("/effects/{id}", get(lists::effect))
        .route("/jobs", post(jobs::start))
        .route("/jobs/{id}", axum::routing::delete(jobs::cancel))
        .route("/jobs/{id}/events", get(jobs::events::events))
        .route("/live", get(live_requests::frames))
        .route("/live/start", post(live_requests::start))
        .route("/live/stop", post(live_requests::stop))
        .route("/jobs/{id}/result", get(jobs::result));
    Router::new()
        .route("/", get(assets::index))
        .route("/assets/{name}", get(assets::file))
        .nest("/api", api)
        .fallback(async || Problem::not_found("there is nothing at this address"))
        .layer(DefaultBodyLimit::max(LARGEST_BODY))
        .layer(from_fn(connections::with_connection))
        .layer(from_fn_with_state(bench.clone(), guard::admit))
        .layer(from_fn_with_state(bench.clone(), guard::guard))
        .with_state(bench)
}
